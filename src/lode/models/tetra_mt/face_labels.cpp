#include "lode/models/tetra_mt/face_labels.h"

#include <algorithm>
#include <utility>

#include "lode/models/tetra_mt/hierarchy.h"
#include "lode/models/tetra_mt/interfaces.h"

namespace lode::tetra_mt {
namespace {

FaceKey key_of(const std::array<std::uint32_t, 3>& face) {
  return face_key(face[0], face[1], face[2]);
}

/// Of the faces of patches, ascending.
std::vector<std::pair<FaceKey, std::uint32_t>> sorted_faces(const TetraMesh& mesh) {
  std::vector<std::pair<FaceKey, std::uint32_t>> faces;
  faces.reserve(mesh.patch_faces.size());
  for (const PatchFace& face : mesh.patch_faces)
    faces.emplace_back(key_of(face.corners), face.patch);
  std::ranges::sort(faces);
  return faces;
}

}  // namespace

std::vector<std::uint32_t> labels_of(const TetraMesh& mesh, std::span<const Tetrahedron> closed) {
  const auto is_other = [&](std::uint32_t region) { return region != mesh.regions.front(); };
  if (!std::ranges::any_of(mesh.regions, is_other) && mesh.patch_faces.empty()) return {};
  std::vector<std::uint32_t> labels = mesh.regions;
  labels.resize(mesh.tetrahedra.size(), 0);
  labels.resize(closed.size(), kOutsideLabel);
  const auto faces = sorted_faces(mesh);
  for (std::size_t slot = mesh.tetrahedra.size(); slot < closed.size(); ++slot) {
    const Tetrahedron& t = closed[slot];
    const auto outside = std::ranges::find(t, mesh.positions.size());
    const FaceKey key = key_of(others(t, static_cast<std::size_t>(outside - t.begin())));
    const auto at =
        std::ranges::lower_bound(faces, key, {}, &std::pair<FaceKey, std::uint32_t>::first);
    if (at != faces.end() && at->first == key) labels[slot] = kOutsideLabel - at->second - 1;
  }
  return labels;
}

}  // namespace lode::tetra_mt
