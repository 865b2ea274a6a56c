target_link_libraries(${target} ${scope} TBB::tbb Threads::Threads)
