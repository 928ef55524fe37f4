#include "lode/api/compared_pyramid.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include "lode/api/compared_insertions.h"
#include "lode/api/edge_walk.h"
#include "lode/models/terrain/delaunay_pyramid/encodings.h"

namespace lode {
namespace {

using delaunay_pyramid::EncodingLimit;
using delaunay_pyramid::Interference;

/// Of encodings by levels.
std::string why_not_of_levels(ModelPart part) {
  switch (part) {
    case ModelPart::links: return "lists without them";
    case ModelPart::variable:
      return "meshes of whole levels do not meet where two of them are side by side";
    default: return "without links nothing leads from a level to the next";
  }
}

/// What an encoding takes beside the places and heights of its vertices, and these.
std::uint64_t with_vertices(const insertions::History& history, std::uint64_t n_bytes) {
  return n_bytes + history.vertices.size() * (sizeof(delaunay::LatticePoint) + sizeof(double));
}

class Lists final : public HistoryCandidate {
 public:
  Lists(std::shared_ptr<SharedHistory> shared, Interference interference, EncodingLimit limit)
      : HistoryCandidate(std::move(shared)), interference_(interference), limit_(limit) {}
  [[nodiscard]] std::string name() const override {
    return name_of(has_links() ? TerrainModel::linked_triangle_lists
                               : TerrainModel::triangle_lists);
  }
  [[nodiscard]] std::string what() const override {
    return has_links() ? "lists of the triangles that each level makes (SLT), with interference "
                         "links"
                       : "lists of the triangles that each level makes (SLT), no links: neither "
                         "zoom nor location but in a mesh";
  }
  [[nodiscard]] std::optional<std::uint64_t> memory_bytes() const override {
    return with_vertices(history(), lists_->n_bytes());
  }
  [[nodiscard]] std::string why_not(ModelPart part) const override {
    return why_not_of_levels(part);
  }
  [[nodiscard]] std::optional<std::uint64_t> n_links() const override {
    return has_links() ? std::optional(lists_->n_links()) : std::nullopt;
  }
  [[nodiscard]] Neighbours neighbours() const override {
    return {Neighbours::Place::nowhere,
            has_links() ? "its links go from level to level, and it keeps no neighbours"
                        : "it keeps triangles alone, and no neighbours"};
  }

 private:
  [[nodiscard]] bool has_links() const { return interference_ == Interference::linked; }
  Result<void> encode(Progress& progress) override {
    LODE_TRY(lists_,
             delaunay_pyramid::TriangleLists::make(history(), times_of(history(), shared().levels),
                                                   interference_, limit_, progress));
    return {};
  }
  [[nodiscard]] delaunay::Tin tin_of_level(std::size_t level) override {
    return lists_->extract(history(), level);
  }
  [[nodiscard]] std::optional<std::uint64_t> zoom_level(std::size_t level,
                                                        const delaunay::Window& window) override {
    if (!has_links()) return {};
    return lists_->zoom(history(), level, window).size();
  }
  [[nodiscard]] std::optional<std::uint64_t> locate_in_level(
      std::size_t level, std::span<const delaunay::LatticePoint> places) override {
    if (!has_links()) return {};
    return count_found(
        places, [&](delaunay::LatticePoint p) { return lists_->locate(history(), level, p); });
  }

  Interference interference_;
  EncodingLimit limit_;
  std::optional<delaunay_pyramid::TriangleLists> lists_;
};

class Complete final : public HistoryCandidate {
 public:
  Complete(std::shared_ptr<SharedHistory> shared, EncodingLimit limit)
      : HistoryCandidate(std::move(shared)), limit_(limit) {}
  [[nodiscard]] std::string name() const override {
    return name_of(TerrainModel::complete_pyramid);
  }
  [[nodiscard]] std::string what() const override {
    return "every level's whole triangulation with neighbours, and interference links";
  }
  [[nodiscard]] std::optional<std::uint64_t> memory_bytes() const override {
    return with_vertices(history(), pyramid_->n_bytes());
  }
  [[nodiscard]] std::string why_not(ModelPart part) const override {
    return why_not_of_levels(part);
  }
  [[nodiscard]] std::optional<std::uint64_t> n_links() const override {
    return pyramid_->n_links();
  }
  [[nodiscard]] Neighbours neighbours() const override {
    return {Neighbours::Place::in_model, "the twins of each level"};
  }
  [[nodiscard]] std::uint64_t walk(double tolerance, std::uint64_t n_tries,
                                   std::uint64_t seed) override {
    const auto& twins = pyramid_->levels()[shared().level_of(tolerance)].twins;
    return walk_edges(static_cast<std::uint32_t>(twins.size() / 2), n_tries, seed,
                      [&](std::uint32_t triangle, unsigned edge) { return twins[triangle][edge]; });
  }

 private:
  Result<void> encode(Progress& progress) override {
    LODE_TRY(pyramid_, delaunay_pyramid::CompletePyramid::make(
                           history(), times_of(history(), shared().levels), limit_, progress));
    return {};
  }
  [[nodiscard]] delaunay::Tin tin_of_level(std::size_t level) override {
    return pyramid_->extract(history(), level);
  }
  [[nodiscard]] std::optional<std::uint64_t> zoom_level(std::size_t level,
                                                        const delaunay::Window& window) override {
    return pyramid_->zoom(history(), level, window).size();
  }
  [[nodiscard]] std::optional<std::uint64_t> locate_in_level(
      std::size_t level, std::span<const delaunay::LatticePoint> places) override {
    return count_found(
        places, [&](delaunay::LatticePoint p) { return pyramid_->locate(history(), level, p); });
  }

  EncodingLimit limit_;
  std::optional<delaunay_pyramid::CompletePyramid> pyramid_;
};

}  // namespace

std::vector<std::unique_ptr<TerrainCandidate>> pyramid_candidates(std::uint64_t memory_limit) {
  const EncodingLimit limit{.n_bytes = memory_limit};
  const auto shared = std::make_shared<SharedHistory>(TerrainModel::delaunay_pyramid);
  std::vector<std::unique_ptr<TerrainCandidate>> all;
  all.push_back(insertions_candidate(shared));
  all.push_back(std::make_unique<Lists>(shared, Interference::left_out, limit));
  all.push_back(std::make_unique<Lists>(shared, Interference::linked, limit));
  all.push_back(std::make_unique<Complete>(shared, limit));
  for (const TerrainModel model :
       {TerrainModel::ternary_triangulation, TerrainModel::implicit_delaunay_pyramid})
    all.push_back(insertions_candidate(std::make_shared<SharedHistory>(model)));
  return all;
}

}  // namespace lode
