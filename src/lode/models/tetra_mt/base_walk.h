#pragma once

// The base of a file as bits: docs/format.md, section 7.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/models/tetra_mt/number_models.h"
#include "lode/models/tetra_mt/open_faces.h"

namespace lode::tetra_mt {

/// Tetrahedra of a base, with those to the vertex outside.
struct BaseTetrahedra {
  std::vector<Tetrahedron> corners;
  std::vector<std::uint32_t> makers;   ///< HierarchyHead::base_makers,
  std::vector<std::uint32_t> regions;  ///< and base_regions.

  friend bool operator==(const BaseTetrahedra&, const BaseTetrahedra&) = default;
};

/// What numbers they may have.
struct BaseLimits {
  std::uint32_t n_vertices = 0;
  std::uint32_t outside = 0;  ///< The number of the vertex outside.
  std::uint32_t n_nodes = 0;
  /// Of tetrahedra inside, and outside; both 1 where regions are not stored.
  std::array<std::uint32_t, 2> n_labels{1, 1};

  [[nodiscard]] bool has_labels() const { return n_labels[0] > 1 || n_labels[1] > 1; }
};

struct BaseModels {
  static constexpr std::size_t kSteps = 4;

  std::array<BitModel, 2> comes;  ///< By whether one came at the last face.
  /// By how many edges say so, how far it is from the face, and how many were asked of before.
  std::array<std::array<std::array<BitModel, 3>, kSteps>, 4> is_candidate;
  BitModel is_outside;
  WideModel vertices;
  /// By how many were asked of before, and whether its last corner was a candidate.
  std::array<std::array<BitModel, 2>, 4> is_beside;
  BitModel is_none;
  WideModel makers;
  std::array<BitModel, 2> is_last_label;  ///< By side.
  WideModel labels;
};

/// Walks from face to face: each tetrahedron comes at the first face, in the order in which they
/// came, that has none across, and its last corner is mostly what is across an edge of that face
/// already. In an order that is not in_base_order()'s more of them begin anew, and take more bits.
template <typename Coder>
class BaseWalk {
 public:
  BaseWalk(Coder& coder, const BaseLimits& limits, const std::string& what)
      : coder_(coder), limits_(limits), what_(what), open_faces_(limits.n_vertices) {}

  /// `mesh`: for a reader, of no tetrahedra, to be filled with n, for which there is memory.
  Result<void> code(BaseTetrahedra& mesh, std::size_t n) {
    mesh_ = &mesh;
    across_.reserve(n);
    gates_.reserve(2 * n);  // about: each face has two
    if constexpr (Coder::kReads) {
      mesh.corners.reserve(n);
      mesh.makers.reserve(n);
      if (limits_.has_labels()) mesh.regions.reserve(n);
    }
    while (true) {
      while (next_gate_ < gates_.size() && across_.size() < n) {
        const Gate gate = gates_[next_gate_++];
        if (across_[gate.tetrahedron][gate.place] != kNone) continue;
        const bool comes = coder_.bit(models_.comes[last_came_], comes_at(gate));
        last_came_ = comes ? 1 : 0;
        if (comes) LODE_CHECK(attach(gate));
      }
      if (across_.size() == n) return {};
      LODE_CHECK(begin_anew());
    }
  }

 private:
  /// A face of a tetrahedron, across from a corner.
  struct Gate {
    std::uint32_t tetrahedron;
    std::uint32_t place;
  };
  struct Candidate {
    std::uint32_t vertex;
    std::uint32_t n_edges;
    std::uint32_t n_steps;
  };

  [[nodiscard]] std::array<std::uint32_t, 3> face_of(const Gate& gate) const {
    return others(mesh_->corners[gate.tetrahedron], gate.place);
  }
  /// Whether what a writer has next begins with the gate's face.
  [[nodiscard]] bool comes_at(const Gate& gate) const {
    if constexpr (Coder::kReads) return false;
    const Tetrahedron& next = mesh_->corners[across_.size()];
    return face_of(gate) == std::array{next[0], next[1], next[2]};
  }

  Result<void> begin_anew() {
    Tetrahedron corners{};
    if constexpr (!Coder::kReads) corners = mesh_->corners[across_.size()];
    for (std::uint32_t& corner : corners) {
      LODE_TRY(corner, code_vertex(last_vertex_, corner));
    }
    LODE_CHECK(add(corners));
    for (std::uint32_t place = 0; place < 4; ++place) open_or_join(place);
    std::array<std::uint32_t, 4> beside{};
    return code_data(beside, 0, 0, kNone);
  }

  Result<void> attach(const Gate& gate) {
    const auto face = face_of(gate);
    const auto index = static_cast<std::uint32_t>(across_.size());
    std::uint32_t apex = 0;
    if constexpr (!Coder::kReads) apex = mesh_->corners[index][3];
    LODE_TRY(const bool is_candidate, code_apex(gate, face, apex));
    LODE_CHECK(add({face[0], face[1], face[2], apex}));
    open_faces_.erase(key_of(gate));
    across_[index][3] = gate.tetrahedron;
    across_[gate.tetrahedron][gate.place] = index;
    for (std::uint32_t place = 0; place < 3; ++place) open_or_join(place);
    // Makers of what is beside it, each once.
    std::array<std::uint32_t, 4> beside{};
    std::uint32_t n = 0;
    for (const std::uint32_t place : {3U, 0U, 1U, 2U}) {
      if (across_[index][place] == kNone) continue;
      const std::uint32_t maker = mesh_->makers[across_[index][place]];
      if (std::find(beside.begin(), beside.begin() + n, maker) == beside.begin() + n)
        beside[n++] = maker;
    }
    return code_data(beside, n, is_candidate ? 1 : 0, gate.tetrahedron);
  }

  /// Whether it is one of the candidates.
  Result<bool> code_apex(const Gate& gate, const std::array<std::uint32_t, 3>& face,
                         std::uint32_t& apex) {
    find_candidates(gate, face);
    for (std::size_t k = 0; k < n_candidates_; ++k) {
      const Candidate& candidate = candidates_[k];
      auto& model = models_.is_candidate[candidate.n_edges][std::min<std::size_t>(
          candidate.n_steps, BaseModels::kSteps - 1)][k];
      if (!coder_.bit(model, candidate.vertex == apex)) continue;
      apex = candidate.vertex;
      return true;
    }
    LODE_TRY(apex, code_vertex(face[0], apex));
    return false;
  }
  Result<std::uint32_t> code_vertex(std::uint32_t from, std::uint32_t given) {
    if (coder_.bit(models_.is_outside, given == limits_.outside)) return limits_.outside;
    if (from == limits_.outside) from = last_vertex_;
    const std::uint64_t vertex = code_difference(models_.vertices, from, given);
    if (vertex >= limits_.n_vertices)
      return fail("{}: expected one of {} vertices of the base, or the one outside, got {}", what_,
                  limits_.n_vertices, vertex);
    last_vertex_ = static_cast<std::uint32_t>(vertex);
    return last_vertex_;
  }
  /// By zigzag, modulo 2^64 wherever bytes lead.
  std::uint64_t code_difference(WideModel& model, std::uint64_t from, std::uint64_t given) {
    const std::uint64_t step = given - from;
    const std::uint64_t code = model.code(coder_, step << 1 ^ (0 - (step >> 63)));
    return from + (code >> 1 ^ (0 - (code & 1)));
  }

  /// What is across from each edge of a face, on its side: as far as tetrahedra go round the edge.
  void find_candidates(const Gate& gate, const std::array<std::uint32_t, 3>& face) {
    n_candidates_ = 0;
    for (std::size_t e = 0; e < 3; ++e) {
      const Candidate found = turn_round(gate, face[e], face[(e + 1) % 3], face[(e + 2) % 3]);
      if (found.vertex == kNone || std::ranges::find(face, found.vertex) != face.end()) continue;
      std::size_t k = 0;
      while (k < n_candidates_ && candidates_[k].vertex != found.vertex) ++k;
      if (k == n_candidates_) {
        candidates_[n_candidates_++] = found;
        continue;
      }
      ++candidates_[k].n_edges;
      candidates_[k].n_steps = std::max(candidates_[k].n_steps, found.n_steps);
    }
    // Those of most edges first, else as they came.
    for (std::size_t k = 1; k < n_candidates_; ++k)
      for (std::size_t i = k; i > 0 && candidates_[i].n_edges > candidates_[i - 1].n_edges; --i)
        std::swap(candidates_[i], candidates_[i - 1]);
  }
  /// From a face (a, b, third) round its edge (a, b), to a face that has none across.
  [[nodiscard]] Candidate turn_round(const Gate& gate, std::uint32_t a, std::uint32_t b,
                                     std::uint32_t third) const {
    constexpr std::uint32_t kMost = 64;
    std::uint32_t at = gate.tetrahedron;
    for (std::uint32_t n = 0; n < kMost; ++n) {
      const Tetrahedron& corners = mesh_->corners[at];
      std::uint32_t left = kNone;   // across from the face to go through
      std::uint32_t other = kNone;  // the fourth corner, which that face has
      for (std::uint32_t k = 0; k < 4; ++k) {
        if (corners[k] == third) left = k;
        if (corners[k] != third && corners[k] != a && corners[k] != b) other = corners[k];
      }
      if (left == kNone || other == kNone) break;
      if (across_[at][left] == kNone) return {other, 1, n};
      at = across_[at][left];
      third = other;
    }
    return {kNone, 0, 0};
  }

  /// A tetrahedron, without what is across.
  Result<void> add(const Tetrahedron& corners) {
    Tetrahedron sorted = corners;
    std::ranges::sort(sorted);
    if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end())
      return fail("{}: expected tetrahedra of four vertices, got vertex {} twice", what_, *twice);
    across_.push_back({kNone, kNone, kNone, kNone});
    if constexpr (Coder::kReads) {
      mesh_->corners.push_back(corners);
      mesh_->makers.push_back(kNone);
      if (limits_.has_labels()) mesh_->regions.push_back(0);
    }
    return {};
  }
  /// A face of the last one: joined with the same face of another, else to be walked through.
  void open_or_join(std::uint32_t place) {
    const auto index = static_cast<std::uint32_t>(across_.size() - 1);
    const FaceKey key = key_of({index, place});
    const std::uint32_t found = open_faces_.find(key);
    if (found == kNone) {
      open_faces_.insert(key, static_cast<std::uint32_t>(gates_.size()));
      gates_.push_back({index, place});
      return;
    }
    const Gate& gate = gates_[found];
    across_[index][place] = gate.tetrahedron;
    across_[gate.tetrahedron][gate.place] = index;
    open_faces_.erase(key);
  }
  [[nodiscard]] FaceKey key_of(const Gate& gate) const {
    const auto face = face_of(gate);
    return face_key(face[0], face[1], face[2]);
  }

  /// Maker and region of the last one. `beside`: makers of those beside it; `through`: the one
  /// across whose face it came, if any.
  Result<void> code_data(const std::array<std::uint32_t, 4>& beside, std::uint32_t n,
                         std::size_t is_candidate, std::uint32_t through) {
    const std::size_t index = across_.size() - 1;
    std::uint32_t& maker = mesh_->makers[index];
    bool is_beside = false;
    for (std::uint32_t k = 0; k < n && !is_beside; ++k) {
      is_beside = coder_.bit(models_.is_beside[k][is_candidate], beside[k] == maker);
      if (is_beside) maker = beside[k];
    }
    if (!is_beside) {
      LODE_TRY(maker, code_maker(maker));
    }
    if (!limits_.has_labels()) return {};
    const Tetrahedron& corners = mesh_->corners[index];
    const std::size_t side = std::ranges::find(corners, limits_.outside) != corners.end() ? 1 : 0;
    std::uint32_t& label = mesh_->regions[index];
    std::uint32_t expected = last_label_[side];
    if (through != kNone && is_on(side, through)) expected = mesh_->regions[through];
    if (coder_.bit(models_.is_last_label[side], label == expected)) {
      label = expected;
    } else {
      const std::uint64_t found = models_.labels.code(coder_, label);
      if (found >= limits_.n_labels[side])
        return fail("{}: expected one of {} {}, got {}", what_, limits_.n_labels[side],
                    side == 1 ? "patches and none" : "regions", found);
      label = static_cast<std::uint32_t>(found);
    }
    last_label_[side] = label;
    return {};
  }
  [[nodiscard]] bool is_on(std::size_t side, std::uint32_t tetrahedron) const {
    const Tetrahedron& corners = mesh_->corners[tetrahedron];
    return (std::ranges::find(corners, limits_.outside) != corners.end()) == (side == 1);
  }
  Result<std::uint32_t> code_maker(std::uint32_t given) {
    if (coder_.bit(models_.is_none, given == kNone)) return kNone;
    const std::uint64_t maker = code_difference(models_.makers, last_maker_, given);
    if (maker >= limits_.n_nodes)
      return fail("{}: expected one of {} nodes, got {}", what_, limits_.n_nodes, maker);
    last_maker_ = static_cast<std::uint32_t>(maker);
    return last_maker_;
  }

  Coder& coder_;
  BaseLimits limits_;
  const std::string& what_;
  BaseModels models_;
  BaseTetrahedra* mesh_ = nullptr;
  std::vector<std::array<std::uint32_t, 4>> across_;  ///< Of those coded.
  std::vector<Gate> gates_;                           ///< All faces as they came.
  std::size_t next_gate_ = 0;
  OpenFaces open_faces_;  ///< Gates.
  std::array<Candidate, 3> candidates_{};
  std::size_t n_candidates_ = 0;
  std::size_t last_came_ = 1;
  std::uint32_t last_vertex_ = 0;
  std::uint32_t last_maker_ = 0;
  std::array<std::uint32_t, 2> last_label_{};
};

}  // namespace lode::tetra_mt
