#include "face_owners.hpp"

#include <algorithm>
#include <span>

#include "lumesh/geometry/tetrahedron.hpp"

namespace lumesh::io {

namespace {

Cell<3> sorted(Cell<3> corners) {
  std::sort(corners.begin(), corners.end());
  return corners;
}

/// Triangles by their smallest vertex: most faces of tetrahedra meet an empty list and are done.
class TriangleTable {
 public:
  explicit TriangleTable(const MeshView& mesh) : first_(mesh.points.size() + 1), ids_(mesh.triangles.size()) {
    for (const Cell<3>& t : mesh.triangles) {
      keys_.push_back(sorted(t));
      ++first_[keys_.back()[0] + 1];
    }
    for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t t = 0; t < keys_.size(); ++t) ids_[next[keys_[t][0]]++] = t;
  }
  /// Calls visit(triangle) for those with these corners.
  template <class Visit>
  void find(const Cell<3>& key, const Visit& visit) const {
    for (std::uint32_t i = first_[key[0]]; i < first_[key[0] + 1]; ++i)
      if (keys_[ids_[i]] == key) visit(ids_[i]);
  }

 private:
  std::vector<std::uint32_t> first_;  ///< Of each vertex, into ids_.
  std::vector<std::uint32_t> ids_;
  std::vector<Cell<3>> keys_;
};

Label first_label(const MeshView& mesh, std::uint32_t triangle) {
  const auto patch = static_cast<std::size_t>(mesh.triangle_patches[triangle]);
  return patch < mesh.info->patches.size() ? mesh.info->patches[patch].labels[0] : kBackground;
}

}  // namespace

std::vector<FaceOwner> find_face_owners(const MeshView& mesh) {
  const TriangleTable table(mesh);
  std::vector<FaceOwner> owners(mesh.triangles.size());
  for (std::uint32_t cell = 0; cell < mesh.tetrahedra.size(); ++cell) {
    const Cell<4>& c = mesh.tetrahedra[cell];
    for (const auto& local : kTetFaces) {
      const Cell<3> face = {c[static_cast<std::size_t>(local[0])], c[static_cast<std::size_t>(local[1])],
                            c[static_cast<std::size_t>(local[2])]};
      table.find(sorted(face), [&](std::uint32_t triangle) {
        FaceOwner& owner = owners[triangle];
        owner.between = owner.cell != FaceOwner::kNone;
        if (owner.between && mesh.tetrahedron_labels[cell] != first_label(mesh, triangle)) return;
        if (owner.between && mesh.tetrahedron_labels[owner.cell] == mesh.tetrahedron_labels[cell]) return;
        owner.cell = cell;
        owner.outward = face;
      });
    }
  }
  return owners;
}

}  // namespace lumesh::io
