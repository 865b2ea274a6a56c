#pragma once
/// @file What was closed of a surface, as JSON.

#include <nlohmann/json.hpp>
#include <span>

#include "lumesh/surface/closing.hpp"

namespace lumesh::cli {

inline nlohmann::ordered_json closed_json(std::span<const surfaces::ClosedRim> closed) {
  const auto list = [](const Vec3& p) { return nlohmann::ordered_json::array({p.x(), p.y(), p.z()}); };
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const surfaces::ClosedRim& rim : closed) {
    nlohmann::ordered_json one = {{"kind", rim.is_opening ? "opening" : "hole"}};
    if (!rim.name.empty()) one["name"] = rim.name;
    one["centre_mm"] = list(rim.centre_mm);
    one["normal"] = list(rim.normal);
    one["area_mm2"] = rim.area_mm2;
    one["rim_radius_mm"] = rim.given.radius_mm;
    one["rim_edges"] = rim.given.vertices.size();
    one["rim_deviation_mm"] = rim.given.deviation_mm;
    one["cut_off_mm"] = rim.cut_off_mm;
    one["moved_mm"] = rim.moved_mm;
    one["triangles"] = rim.triangles;
    one["smallest_angle_deg"] = rim.smallest_angle_deg;
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace lumesh::cli
