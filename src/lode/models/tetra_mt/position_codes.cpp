#include "lode/models/tetra_mt/position_codes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lode/models/tetra_mt/ordered_bits.h"

namespace lode::tetra_mt {
namespace {

/// How a place differs from the one before.
enum Step : std::uint32_t { same = 0, next = 1, last = 2, farther = 3 };

struct Axis {
  std::vector<std::uint64_t> table;  ///< Ascending; empty where there are differences.
  std::uint64_t before = 0;          ///< Place in the table, or number, of the vertex before.
};

template <typename Coder>
class PositionCoder {
 public:
  PositionCoder(Coder& coder, PositionModels& models, bool is_narrow, const std::string& what)
      : coder_(coder), models_(models), is_narrow_(is_narrow), what_(what) {}

  Result<void> run(std::vector<Vec3d>& positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) LODE_CHECK(code_table(axis, positions));
    for (Vec3d& p : positions) {
      // As they are before this one.
      const std::uint64_t parities =
          parity_of(axes_[0]) | parity_of(axes_[1]) << 1 | parity_of(axes_[2]) << 2;
      std::size_t steps = 0;
      for (std::size_t axis = 3; axis-- > 0;) {
        LODE_CHECK(axes_[axis].table.empty() ? code_difference(axis, p[axis])
                                             : code_place(axis, parities, steps, p[axis]));
      }
    }
    return {};
  }

 private:
  [[nodiscard]] static std::uint64_t parity_of(const Axis& axis) {
    return axis.table.empty() ? 0 : axis.before & 1;
  }
  Result<void> code_table(std::size_t axis, const std::vector<Vec3d>& positions) {
    std::vector<std::uint64_t> given;
    if (!Coder::kReads) {
      for (const Vec3d& p : positions) given.push_back(to_ordered(p[axis], is_narrow_));
      std::ranges::sort(given);
      given.erase(std::unique(given.begin(), given.end()), given.end());
      if (2 * given.size() > positions.size()) given.clear();
    }
    std::vector<std::uint64_t>& table = axes_[axis].table;
    table.resize(code_plain(coder_, 10, given.size()));
    given.resize(table.size());
    if (table.size() > positions.size())
      return fail("{}: expected up to {} coordinates, got {}", what_, positions.size(),
                  table.size());
    for (std::size_t i = 0; i < table.size(); ++i) {
      const std::uint64_t before = i == 0 ? 0 : table[i - 1] + 1;
      WideModel& model = i == 0 ? models_.firsts : models_.gaps[axis];
      const std::uint64_t gap = model.code(coder_, given[i] - before);
      const bool is_after = before <= largest_ordered(is_narrow_) && (i == 0 || before > 0);
      if (!is_after || gap > largest_ordered(is_narrow_) - before)
        return fail("{}: expected coordinates that ascend", what_);
      table[i] = before + gap;
    }
    return {};
  }
  Result<void> code_difference(std::size_t axis, double& coordinate) {
    Axis& at = axes_[axis];
    const std::uint64_t given = to_ordered(coordinate, is_narrow_) - at.before;
    const std::uint64_t code =
        models_.differences[axis].code(coder_, given << 1 ^ (0 - (given >> 63)));
    at.before += code >> 1 ^ (0 - (code & 1));
    if (at.before > largest_ordered(is_narrow_))
      return fail("{}: expected coordinates of float32", what_);
    return set(at.before, coordinate);
  }
  /// `steps`: of the axes before, and then of this one too.
  Result<void> code_place(std::size_t axis, std::uint64_t parities, std::size_t& steps,
                          double& coordinate) {
    Axis& at = axes_[axis];
    auto& models = models_.steps[axis][parities][steps];
    std::int64_t difference = 0;
    if (!Coder::kReads) {
      const auto place = std::ranges::lower_bound(at.table, to_ordered(coordinate, is_narrow_));
      difference = place - at.table.begin() - static_cast<std::int64_t>(at.before);
    }
    Step step = same;
    if (coder_.bit(models[0], difference != 0)) {
      step = next;
      if (coder_.bit(models[1], difference != 1))
        step = coder_.bit(models[2], difference != -1) ? farther : last;
    }
    if (step == farther) {
      const bool is_back = coder_.bit(models_.is_back[axis], difference < 0);
      const auto size = static_cast<std::uint32_t>(difference < 0 ? -difference : difference);
      const auto found = static_cast<std::int64_t>(models_.far[axis].code(coder_, size - 2)) + 2;
      difference = is_back ? -found : found;
    } else {
      difference = step == last ? -1 : static_cast<std::int64_t>(step);
    }
    at.before += static_cast<std::uint64_t>(difference);
    steps = 4 * steps + step;
    if (at.before >= at.table.size())
      return fail("{}: expected places of {} coordinates", what_, at.table.size());
    return set(at.table[at.before], coordinate);
  }
  Result<void> set(std::uint64_t ordered, double& coordinate) const {
    if (!Coder::kReads) return {};
    coordinate = from_ordered(ordered, is_narrow_);
    if (!std::isfinite(coordinate))
      return fail("{}: expected finite numbers, got {}", what_, coordinate);
    return {};
  }

  Coder& coder_;
  PositionModels& models_;
  bool is_narrow_;
  const std::string& what_;
  std::array<Axis, 3> axes_;
};

}  // namespace

template <typename Coder>
Result<void> code_positions(Coder& coder, PositionModels& models, bool is_narrow,
                            const std::string& what, std::vector<Vec3d>& positions) {
  return PositionCoder<Coder>(coder, models, is_narrow, what).run(positions);
}

template Result<void> code_positions(RangeWriter&, PositionModels&, bool, const std::string&,
                                     std::vector<Vec3d>&);
template Result<void> code_positions(RangeReader&, PositionModels&, bool, const std::string&,
                                     std::vector<Vec3d>&);

}  // namespace lode::tetra_mt
