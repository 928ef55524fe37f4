#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/api/tetra_cut_source.h"
#include "lode/api/tetra_dataset.h"
#include "lode/api/tetra_probe.h"
#include "lode/models/tetra_mt/midpoint/forest.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"
#include "lode/models/tetra_mt/persist.h"

namespace lode {

class TetraDataset::Impl {
 public:
  using GradientSource =
      std::function<Result<std::vector<std::uint32_t>>(std::size_t field, std::uint32_t page)>;

  Impl(tetra_mt::PackedHierarchy packed, GradientSource source,
       std::function<tetra_mt::FileReads()> reads_of = {});
  explicit Impl(tetra_mt::midpoint::Forest made,
                std::function<tetra_mt::FileReads()> reads_of = {});

  [[nodiscard]] ProbedHierarchy probed() const {
    if (hierarchy) return &*hierarchy;
    return &*midpoints;
  }
  [[nodiscard]] std::unique_ptr<const TetraCutSource> source() const {
    return hierarchy ? source_of(*hierarchy) : source_of(*midpoints);
  }
  /// Of a lean file there are none, nor of midpoints.
  [[nodiscard]] bool has_gradients() const { return source_ != nullptr; }
  /// Of vertices of the hierarchy, ascending.
  [[nodiscard]] Result<std::vector<Vec3f>> gradients(std::span<const std::uint32_t> vertices,
                                                     std::size_t field) const;

  std::optional<tetra_mt::PackedHierarchy> hierarchy;   ///< This,
  std::optional<tetra_mt::midpoint::Forest> midpoints;  ///< or this.
  std::function<tetra_mt::FileReads()> reads;           ///< None in memory.
  TetraInfo info;
  Vec3d surface_origin;
  double surface_margin;

 private:
  [[nodiscard]] Result<const std::vector<std::uint32_t>*> load_gradients(std::size_t field,
                                                                         std::uint32_t page) const;

  GradientSource source_;
  mutable std::mutex mutex_;
  /// Codes by field and page, of those looked at so far.
  mutable std::map<std::pair<std::size_t, std::uint32_t>, std::vector<std::uint32_t>> pages_;
};

}  // namespace lode
