#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "lode/core/volume.h"
#include "lode/models/diamond/lattice.h"
#include "tests/oracles/typed_samples.h"

namespace lode::test {

/// Regions of samples on one side of an isovalue, joined by the edges of the finest tetrahedra: by
/// brute force.
class Regions {
 public:
  /// `fixed`: samples farther than the persistence from the isovalue.
  Regions(const Index3& dims, const std::vector<double>& values, double isovalue,
          const std::vector<bool>& fixed)
      : dims_(dims), region_of_(values.size(), -1) {
    const auto side = [&](std::size_t i) { return values[i] >= isovalue; };
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (std::isnan(values[i]) || region_of_[i] >= 0) continue;
      const auto number = static_cast<int>(i);  // the first sample's: ties go by it
      Region& region = regions_[number];
      std::vector<std::size_t> waiting{i};
      region_of_[i] = number;
      while (!waiting.empty()) {
        const std::size_t p = waiting.back();
        waiting.pop_back();
        region.samples.push_back(p);
        region.is_fixed = region.is_fixed || fixed[p];
        for_each_beside(p, [&](std::size_t q) {
          if (std::isnan(values[q]) || region_of_[q] >= 0 || side(q) != side(p)) return;
          region_of_[q] = number;
          waiting.push_back(q);
        });
      }
    }
    for (std::size_t p = 0; p < values.size(); ++p)
      for_each_beside(p, [&](std::size_t q) {
        if (region_of_[p] >= 0 && region_of_[q] >= 0 && region_of_[p] != region_of_[q])
          regions_[region_of_[p]].beside.insert(region_of_[q]);
      });
  }

  [[nodiscard]] std::size_t n_fixed() const {
    return static_cast<std::size_t>(std::ranges::count_if(
        regions_, [](const auto& numbered) { return numbered.second.is_fixed; }));
  }
  /// Turns the smallest regions that are not fixed, until there are none. By sample: whether it is
  /// on the other side then.
  [[nodiscard]] std::vector<bool> turn() {
    std::vector<bool> turned(region_of_.size());
    for (int number = weakest(); number >= 0; number = weakest()) {
      Region region = regions_[number];
      for (const std::size_t p : region.samples) turned[p] = !turned[p];
      merge(number, region);
    }
    return turned;
  }

 private:
  struct Region {
    std::vector<std::size_t> samples;
    std::set<int> beside;
    bool is_fixed = false;
  };

  template <typename See>
  void for_each_beside(std::size_t at, const See& see) const {
    const Index3 p = diamond::point_of<3>(dims_, at);
    for (std::size_t i = 0; i < 27; ++i) {
      const Index3 d = diamond::point_of<3>({{3, 3, 3}}, i) - Index3{{1, 1, 1}};
      const Index3 q = p + d;
      std::array<bool, 2> moves_from{};  // an even coordinate, an odd one
      bool is_sample = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        is_sample = is_sample && q[axis] >= 0 && q[axis] < dims_[axis];
        if (d[axis] != 0) moves_from[static_cast<std::size_t>(p[axis] & 1)] = true;
      }
      if (is_sample && moves_from[0] != moves_from[1]) see(diamond::linear_index<3>(dims_, q));
    }
  }
  /// -1: none.
  [[nodiscard]] int weakest() const {
    int best = -1;
    for (const auto& [number, region] : regions_)
      if (!region.is_fixed && !region.beside.empty() &&
          (best < 0 || region.samples.size() < regions_.at(best).samples.size()))
        best = number;
    return best;
  }
  /// Gets the number of the first sample of all.
  void merge(int number, Region region) {
    std::set<int> others = std::move(region.beside);
    region.beside.clear();
    const int first = std::min(number, *others.begin());
    regions_.erase(number);
    for (const int other : others) {
      const Region& more = regions_.at(other);
      region.samples.insert(region.samples.end(), more.samples.begin(), more.samples.end());
      region.is_fixed = region.is_fixed || more.is_fixed;
      for (const int beside : more.beside)
        if (beside != number && !others.contains(beside)) region.beside.insert(beside);
      regions_.erase(other);
    }
    for (const int beside : region.beside) {
      std::set<int>& theirs = regions_.at(beside).beside;
      for (const int other : others) theirs.erase(other);
      theirs.insert(first);
    }
    regions_[first] = std::move(region);
  }

  Index3 dims_;
  std::vector<int> region_of_;
  std::map<int, Region> regions_;
};

/// What becomes of a volume on whose sides of an isovalue regions are turned over that have no
/// sample which `before` has farther from it than the persistence.
inline Volume without_weak_regions(const Volume& volume, const Volume& before, double isovalue,
                                   double persistence) {
  Volume result = volume;
  const auto samples = oracles::typed_samples<float>(result);
  const auto values = volume.as<float>();
  const auto own = before.as<float>();
  const std::vector<double> of(values.begin(), values.end());
  std::vector<bool> fixed;
  for (std::size_t i = 0; i < of.size(); ++i) {
    const auto sample = static_cast<double>(own[i]);
    fixed.push_back(of[i] >= isovalue ? sample >= isovalue + persistence
                                      : sample < isovalue - persistence);
  }
  const std::vector<bool> turned = Regions(volume.info.grid.dims, of, isovalue, fixed).turn();
  auto inside = static_cast<float>(isovalue);
  if (static_cast<double>(inside) < isovalue) inside = std::nextafter(inside, 1e30F);
  for (std::size_t i = 0; i < of.size(); ++i) {
    if (!turned[i]) continue;
    EXPECT_FALSE(fixed[i]);
    samples[i] = of[i] >= isovalue ? std::nextafter(inside, -1e30F) : inside;
  }
  return result;
}

}  // namespace lode::test
