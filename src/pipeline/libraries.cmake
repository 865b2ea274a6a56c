target_link_libraries(${target} PRIVATE fmt::fmt nlohmann_json::nlohmann_json)
