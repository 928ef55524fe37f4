#include "lode/models/diamond/compare_blocks.h"

#include <fmt/ranges.h>

#include <cstring>

#include "lode/core/parallel_check.h"
#include "lode/models/diamond/block_values.h"
#include "lode/models/diamond/read_region.h"
#include "lode/models/diamond/world_code.h"

namespace lode::diamond {
namespace {

void append_finding(AttributeFinding& all, const AttributeFinding& later) {
  all.n_checked += later.n_checked;
  if (all.n_wrong == 0) all.worst = later.worst;
  all.n_wrong += later.n_wrong;
}

/// The i-th of a region's points, in steps of its level.
template <int D>
Index<D> point_at(const Region<D>& r, std::size_t i) {
  Index<D> found;
  std::size_t first = 0;
  for_each_row<D>(r, [&](Index<D> q, std::int32_t n, std::int32_t stride) {
    if (first <= i && i < first + as_size(n)) {
      q[0] += static_cast<std::int32_t>(i - first) * stride;
      found = q;
    }
    first += as_size(n);
  });
  return found;
}

/// The blocks of one group: ours, and those of the file.
template <int D>
class GroupComparison {
 public:
  GroupComparison(const ComparedFile<D>& file, const BlockGroup<D>& group)
      : file_(file), group_(group), region_(group.region) {}

  template <typename Field>
  Result<void> run(const Field& field, const WorldErrors& worlds, const Index<D>& origin,
                   BlockFindings& findings) {
    n_ = count_points(region_);
    if (n_ == 0) return {};
    if (group_.is_samples && !reaches_beyond()) {  // those in the data are what ours are made of
      const auto found = find_region<D>(file_.reader, region_, Kind::samples, field.sample_size());
      if (!found) return found.error();
      ++findings.n_blocks;
      return {};
    }
    visit_block_values<D>(field, worlds, origin, group_, [&](Kind kind, const auto& values) {
      const auto bytes = std::as_bytes(std::span(values));
      ours_[place_of(kind)].assign(bytes.begin(), bytes.end());
    });
    if (group_.is_samples) return compare_samples(field.storage, findings);
    LODE_CHECK(visit_range_type(
        field.storage, [&]<typename R>() { return this->template compare_nodes<R>(findings); }));
    return file_.with_worlds ? compare_worlds(findings) : Result<void>();
  }

 private:
  [[nodiscard]] static std::size_t place_of(Kind kind) { return static_cast<std::size_t>(kind); }
  [[nodiscard]] bool reaches_beyond() const {
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (((region_.upper[i] - 1) << region_.level) >= file_.shape.dims[i]) return true;
    return false;
  }
  [[nodiscard]] Result<void> read(Kind kind, std::size_t element_size, BlockFindings& findings) {
    LODE_TRY(theirs_[place_of(kind)], read_region<D>(file_.reader, region_, kind, element_size));
    ++findings.n_blocks;
    return {};
  }
  [[nodiscard]] bool are_equal(Kind kind) const {
    return ours_[place_of(kind)] == theirs_[place_of(kind)];
  }
  template <typename T>
  [[nodiscard]] static T value_at(const std::vector<std::byte>& bytes, std::size_t i) {
    T value;
    std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
    return value;
  }
  template <typename T>
  [[nodiscard]] T ours(Kind kind, std::size_t i) const {
    return value_at<T>(ours_[place_of(kind)], i);
  }
  template <typename T>
  [[nodiscard]] T theirs(Kind kind, std::size_t i) const {
    return value_at<T>(theirs_[place_of(kind)], i);
  }
  /// As bits: holes may be any NaN.
  template <typename T>
  [[nodiscard]] bool has_other_bits(Kind kind, std::size_t i) const {
    return std::memcmp(ours_[place_of(kind)].data() + i * sizeof(T),
                       theirs_[place_of(kind)].data() + i * sizeof(T), sizeof(T)) != 0;
  }
  /// As numbers; no number is equal to none.
  template <typename T>
  [[nodiscard]] bool differ(Kind kind, std::size_t i) const {
    return !(ours<T>(kind, i) == theirs<T>(kind, i));
  }
  [[nodiscard]] static std::string text_of(ErrorCode error) {
    return error > kInfiniteError ? fmt::format("none (code {})", error)
                                  : fmt::format("{}", decode_error(error));
  }
  /// The finding of nodes of which is_wrong(i) says so; describe(i): of the first.
  template <typename IsWrong, typename Describe>
  void count(const IsWrong& is_wrong, const Describe& describe, AttributeFinding& finding) const {
    for (std::size_t i = 0; i < n_; ++i) {
      if (!is_wrong(i)) continue;
      if (finding.n_wrong++ == 0)
        finding.worst = fmt::format("first: level {}, node {} of its grid: {}", region_.level,
                                    fmt::join(point_at(region_, i).v, " "), describe(i));
    }
  }

  [[nodiscard]] Result<void> compare_samples(ScalarType storage, BlockFindings& findings) {
    LODE_CHECK(read(Kind::samples, size_of(storage), findings));
    if (are_equal(Kind::samples)) return {};
    return visit_storage_type(storage, [&]<typename T>() -> Result<void> {
      std::size_t i = 0;
      while (!has_other_bits<T>(Kind::samples, i)) ++i;
      return fail(
          "{}: {}: beyond the data at grid point {}: expected the nearest sample, {}, got {}",
          file_.reader.path(), describe(key_of(Kind::samples, region_)),
          fmt::join(point_at(region_, i).v, " "), ours<T>(Kind::samples, i),
          theirs<T>(Kind::samples, i));
    });
  }
  template <typename R>
  [[nodiscard]] Result<void> compare_nodes(BlockFindings& findings) {
    LODE_CHECK(read(Kind::errors, sizeof(ErrorCode), findings));
    LODE_CHECK(read(Kind::lows, sizeof(R), findings));
    LODE_CHECK(read(Kind::highs, sizeof(R), findings));
    findings.nodes.n_checked += n_;
    if (are_equal(Kind::errors) && are_equal(Kind::lows) && are_equal(Kind::highs)) return {};
    count(
        [&](std::size_t i) {
          return differ<ErrorCode>(Kind::errors, i) || differ<R>(Kind::lows, i) ||
                 differ<R>(Kind::highs, i);
        },
        [&](std::size_t i) {
          return fmt::format("error {}, range {} to {}; of the samples {}, {} to {}",
                             text_of(theirs<ErrorCode>(Kind::errors, i)), theirs<R>(Kind::lows, i),
                             theirs<R>(Kind::highs, i), text_of(ours<ErrorCode>(Kind::errors, i)),
                             ours<R>(Kind::lows, i), ours<R>(Kind::highs, i));
        },
        findings.nodes);
    return {};
  }
  [[nodiscard]] Result<void> compare_worlds(BlockFindings& findings) {
    LODE_CHECK(read(Kind::worlds, sizeof(WorldCode), findings));
    findings.worlds.n_checked += n_;
    if (are_equal(Kind::worlds)) return {};
    count([&](std::size_t i) { return differ<WorldCode>(Kind::worlds, i); },
          [&](std::size_t i) {
            return fmt::format("{} edges; of the samples {}",
                               decode_world(theirs<WorldCode>(Kind::worlds, i)),
                               decode_world(ours<WorldCode>(Kind::worlds, i)));
          },
          findings.worlds);
    return {};
  }

  static constexpr std::size_t kKinds = static_cast<std::size_t>(Kind::worlds) + 1;

  const ComparedFile<D>& file_;
  const BlockGroup<D>& group_;
  const Region<D>& region_;
  std::size_t n_ = 0;  ///< Points.
  std::array<std::vector<std::byte>, kKinds> ours_;
  std::array<std::vector<std::byte>, kKinds> theirs_;
};

}  // namespace

void BlockFindings::append(const BlockFindings& later) {
  append_finding(nodes, later.nodes);
  append_finding(worlds, later.worlds);
  n_blocks += later.n_blocks;
}

template <int D, typename Field>
Result<void> compare_groups(const ComparedFile<D>& file, const Field& field,
                            const WorldErrors& worlds, const Index<D>& origin,
                            std::span<const BlockGroup<D>> groups, Threads threads,
                            const Progress& progress, BlockFindings& findings) {
  std::vector<BlockFindings> by_group(groups.size());
  LODE_CHECK(check_all(groups.size(), threads, [&](std::size_t i) -> Result<void> {
    if (progress.is_cancelled()) return cancelled_error();
    return GroupComparison<D>(file, groups[i]).run(field, worlds, origin, by_group[i]);
  }));
  for (const BlockFindings& group : by_group) findings.append(group);
  return {};
}

template Result<void> compare_groups<2>(const ComparedFile<2>&, const Model<2>&, const WorldErrors&,
                                        const Index<2>&, std::span<const BlockGroup<2>>, Threads,
                                        const Progress&, BlockFindings&);
template Result<void> compare_groups<3>(const ComparedFile<3>&, const Model<3>&, const WorldErrors&,
                                        const Index<3>&, std::span<const BlockGroup<3>>, Threads,
                                        const Progress&, BlockFindings&);
template Result<void> compare_groups<2>(const ComparedFile<2>&, const CoarseField<2>&,
                                        const WorldErrors&, const Index<2>&,
                                        std::span<const BlockGroup<2>>, Threads, const Progress&,
                                        BlockFindings&);
template Result<void> compare_groups<3>(const ComparedFile<3>&, const CoarseField<3>&,
                                        const WorldErrors&, const Index<3>&,
                                        std::span<const BlockGroup<3>>, Threads, const Progress&,
                                        BlockFindings&);

}  // namespace lode::diamond
