#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/three_numbers.hpp"
#include "lumesh/image/phantom.hpp"
#include "phantom_kinds.hpp"

namespace lumesh {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 5> kKindNames = {"carotid", "bifurcation", "layered", "sphere",
                                                        "torus"};
constexpr int kFormatVersion = 1;

[[noreturn]] void throw_bad_spec(const PhantomSpec& spec, const std::string& what) {
  throw Error(ErrorKind::kUsage, fmt::format("phantom {}: {}", phantom_kind_name(spec.kind), what));
}

void check_noise(const PhantomSpec& spec) {
  const double thinnest = spec.kind == PhantomKind::kLayered ? spec.radius_mm
                          : spec.end_radius_mm > 0           ? spec.end_radius_mm
                                                             : spec.radius_mm;
  const double noise_mm = spec.noise_voxels * spec.spacing_mm.maxCoeff();
  if (noise_mm > 0.4 * thinnest)
    throw_bad_spec(spec,
                   fmt::format("noise of {:.3g} mm is more than 0.4 times the smallest radius, {:.3g} mm",
                               noise_mm, thinnest));
}

template <class Value>
Json to_json(const Value& value) {
  if constexpr (std::is_class_v<Value>)
    return Json::array({value.x(), value.y(), value.z()});
  else
    return value;
}

template <class Value>
void take_json(const Json& json, Value& value) {
  if constexpr (std::is_class_v<Value>) {
    using Scalar = typename Value::Scalar;
    if (!json.is_array() || json.size() != 3) throw std::invalid_argument("must be three numbers");
    value = {json[0].get<Scalar>(), json[1].get<Scalar>(), json[2].get<Scalar>()};
  } else {
    value = json.get<Value>();
  }
}

/// Calls visit(name, field) for all fields but the kind.
template <class Spec, class Visit>
void for_each_field(Spec& spec, const Visit& visit) {
  visit("size", spec.size);
  visit("spacing_mm", spec.spacing_mm);
  visit("radius_mm", spec.radius_mm);
  visit("end_radius_mm", spec.end_radius_mm);
  visit("sac_radius_mm", spec.sac_radius_mm);
  visit("ring_radius_mm", spec.ring_radius_mm);
  visit("wall_mm", spec.wall_mm);
  visit("noise_voxels", spec.noise_voxels);
  visit("seed", spec.seed);
  visit("rotation_deg", spec.rotation_deg);
  visit("origin_mm", spec.origin_mm);
}

void read_field(PhantomSpec& spec, const std::string& key, const Json& value) {
  if (key == "lumesh_phantom" && value != kFormatVersion)
    throw std::invalid_argument("is not a known version");
  bool is_known = key == "lumesh_phantom";
  if (key == "kind") {
    spec.kind = phantom_kind_from_name(value.get<std::string>());
    is_known = true;
  }
  for_each_field(spec, [&](const char* name, auto& field) {
    if (key != name) return;
    take_json(value, field);
    is_known = true;
  });
  if (!is_known) throw std::invalid_argument("is not a field of a phantom");
}

}  // namespace

std::string_view phantom_kind_name(PhantomKind kind) {
  return kKindNames.at(static_cast<std::size_t>(kind));
}

PhantomKind phantom_kind_from_name(std::string_view name) {
  for (std::size_t k = 0; k < kKindNames.size(); ++k)
    if (kKindNames[k] == name) return static_cast<PhantomKind>(k);
  std::string known;
  for (const std::string_view kind : kKindNames) known += (known.empty() ? "" : ", ") + std::string(kind);
  throw Error(ErrorKind::kUsage, "no phantom \"" + std::string(name) + "\"; choose one of " + known);
}

void PhantomSpec::describe(OptionList& list) {
  describe_image(list);
  const auto length = [&](const char* name, double& target, std::string meaning) {
    list.number(name, target, at_least(0), std::move(meaning)).in("mm").zero("by kind");
  };
  const image::PhantomReference carotid = image::reference_of(PhantomKind::kCarotid),
                                bifurcation = image::reference_of(PhantomKind::kBifurcation),
                                ball = image::reference_of(PhantomKind::kSphere),
                                torus = image::reference_of(PhantomKind::kTorus);
  length("radius", radius_mm,
         fmt::format(
             "Radius of the inlet, ball or tube; default {:g}, bifurcation {:g}, layered and sphere {:g}, "
             "torus {:g} voxels of the default image, scaled with the image's extent",
             carotid.radius, bifurcation.radius, ball.radius, torus.radius));
  length("end_radius", end_radius_mm,
         fmt::format("Radius of the smallest outlet; default {:.2g} (bifurcation {:.2g}) radii",
                     carotid.end_radius / carotid.radius, bifurcation.end_radius / bifurcation.radius));
  length("sac_radius", sac_radius_mm,
         fmt::format("Radius of the sac or dome; default {:g} (bifurcation {:g}) such voxels",
                     carotid.sac_radius, bifurcation.sac_radius));
  length("ring_radius", ring_radius_mm,
         fmt::format("Radius of the torus' core circle; default {:g} such voxels", torus.ring_radius));
  length("wall", wall_mm,
         fmt::format("Thickness of the wall of layered; default {:g} voxels", image::kUsualWall));
  list.number("seed", seed, at_least(0), "Seed of the noise");
  list.rows("rotate", exactly_three_numbers(rotation_deg, "0,30,0"),
            "Turns of the image's axes about x, then y, then z")
      .in("degrees");
  list.rows("origin", exactly_three_numbers(origin_mm, "-10,0,25.5"), "Centre of the first voxel").in("mm");
}

void PhantomSpec::describe_image(OptionList& list, const std::string& prefix) {
  list.rows(prefix + "size", three_numbers(size, "256,256,254"), "Number of the phantom's voxels")
      .zero("by kind")
      .range = between(8, 2048);
  list.rows(prefix + "spacing", three_numbers(spacing_mm, "0.5,0.5,0.6"), "Size of the phantom's voxels")
      .in("mm")
      .zero("by kind")
      .range = above(0);
  list.number(prefix + "noise", noise_voxels, between(0, 2), "How far the phantom's boundary moves")
      .in("voxels");
}

PhantomSpec resolve(const PhantomSpec& spec) {
  PhantomSpec full = spec;
  naming(fmt::format("phantom {}", phantom_kind_name(spec.kind)), [&] { require_ranges_of(spec); });
  image::fill_defaults(full);
  // By kind are all three numbers or none.
  if ((full.size.array() == 0).any()) throw_bad_spec(spec, "size must be positive in every direction");
  if ((full.spacing_mm.array() == 0).any()) throw_bad_spec(spec, "every spacing must be positive");
  image::check_radii(full);
  check_noise(full);
  return full;
}

std::string to_json_text(const PhantomSpec& spec) {
  Json json = {{"lumesh_phantom", kFormatVersion}, {"kind", std::string(phantom_kind_name(spec.kind))}};
  for_each_field(spec, [&](const char* name, const auto& field) { json[name] = to_json(field); });
  return json.dump(2) + "\n";
}

PhantomSpec phantom_spec_from_json(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("kind"))
    throw Error(ErrorKind::kBadInput, "phantom parameters: not a JSON object with a \"kind\"");
  PhantomSpec spec;
  for (const auto& [key, value] : json.items()) {
    try {
      read_field(spec, key, value);
    } catch (const std::exception& error) {
      throw Error(ErrorKind::kBadInput, fmt::format("phantom parameters: \"{}\" {}", key, error.what()));
    }
  }
  return spec;
}

}  // namespace lumesh
