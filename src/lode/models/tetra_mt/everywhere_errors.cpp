#include "lode/models/tetra_mt/everywhere_errors.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "lode/models/tetra_mt/reference_overlay.h"

namespace lode::tetra_mt {
namespace {

using FaceCorners = std::array<std::uint32_t, 3>;

FaceCorners corners_of_face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  FaceCorners face{a, b, c};
  std::ranges::sort(face);
  return face;
}

/// The star of a vertex before it went.
struct RemovedStar {
  std::uint32_t kept;
  std::span<const std::uint32_t> link;
  std::span<const std::array<std::uint8_t, 3>> triangles;
  std::span<const std::uint8_t> makers;
};

/// Faces of the tetrahedra that come of a collapse, but those of the reference.
void find_faces(const RemovedStar& star, std::uint32_t outside, std::vector<FaceCorners>& faces) {
  faces.clear();
  std::vector<FaceCorners> known;
  for (std::size_t i = 0; i < star.triangles.size(); ++i) {
    const auto& places = star.triangles[i];
    const FaceCorners t{star.link[places[0]], star.link[places[1]], star.link[places[2]]};
    if (std::ranges::find(t, outside) != t.end()) continue;
    const bool is_reference = star.makers[i] == CollapseStars::kReference;
    const bool goes = std::ranges::find(t, star.kept) != t.end();
    if (goes && is_reference) known.push_back(corners_of_face(t[0], t[1], t[2]));
    if (goes) continue;
    if (!is_reference) faces.push_back(corners_of_face(t[0], t[1], t[2]));
    for (std::size_t k = 0; k < 3; ++k)
      faces.push_back(corners_of_face(star.kept, t[k], t[(k + 1) % 3]));
  }
  std::ranges::sort(faces);
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  for (const FaceCorners& face : known) std::erase(faces, face);
}

}  // namespace

Result<EverywhereReport> make_errors_hold_everywhere(const TetraMesh& mesh,
                                                     HalfEdgeCollapses& collapses, Threads threads,
                                                     Progress& progress) {
  const std::size_t n_fields = mesh.fields.size();
  const auto outside = static_cast<std::uint32_t>(mesh.positions.size());
  const ReferenceOverlay overlay(mesh, 2 * collapses.boundary_deviation);
  struct Worker {
    ReferenceOverlay::Scratch scratch;
    std::vector<FaceCorners> faces;
    std::vector<double> largest;
    EverywhereReport report;
  };
  std::vector<double> ranges;
  for (const MeshField& field : mesh.fields) {
    double& range = ranges.emplace_back(0);
    if (field.values.empty()) continue;
    const auto [low, high] = std::ranges::minmax(field.values);
    range = high - low;
  }
  std::vector<Worker> workers(static_cast<std::size_t>(n_workers(threads)));
  std::vector<std::size_t> firsts;
  std::size_t n = 0;
  for (const CollapseStars& stars : collapses.stars) {
    firsts.push_back(n);
    n += stars.sizes.size();
  }
  parallel_for(collapses.stars.size(), threads, 1, [&](std::size_t piece, int number) {
    if (progress.is_cancelled()) return;
    Worker& worker = workers[static_cast<std::size_t>(number)];
    worker.largest.resize(n_fields);
    const CollapseStars& stars = collapses.stars[piece];
    std::size_t link = 0;
    std::size_t triangle = 0;
    for (std::size_t i = 0; i < stars.sizes.size(); ++i) {
      const CollapseStars::Size& size = stars.sizes[i];
      const std::size_t collapse = firsts[piece] + i;
      const RemovedStar star{collapses.collapses[collapse].kept,
                             std::span(stars.link).subspan(link, size.n_link),
                             std::span(stars.triangles).subspan(triangle, size.n_triangles),
                             std::span(stars.makers).subspan(triangle, size.n_triangles)};
      link += size.n_link;
      triangle += size.n_triangles;
      find_faces(star, outside, worker.faces);
      const auto facts = std::span(collapses.facts).subspan(collapse * n_fields, n_fields);
      for (const FaceCorners& face : worker.faces) {
        ++worker.report.n_faces;
        const bool is_found = overlay.largest_differences(face, worker.largest, worker.scratch);
        if (!is_found) ++worker.report.n_by_range;
        for (std::size_t f = 0; f < n_fields; ++f)
          facts[f].error = std::max(facts[f].error, is_found ? worker.largest[f] : ranges[f]);
      }
    }
  });
  if (progress.is_cancelled()) return cancelled_error();
  collapses.has_errors_everywhere = true;
  EverywhereReport report;
  for (const Worker& worker : workers) {
    report.n_faces += worker.report.n_faces;
    report.n_by_range += worker.report.n_by_range;
  }
  return report;
}

}  // namespace lode::tetra_mt
