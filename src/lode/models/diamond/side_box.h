#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/diamond/file_parts.h"

namespace lode::diamond {

/// The sides of an isovalue that the samples in a box of a lattice are on, which tell its critical
/// nodes (see find_critical_nodes()). The lattice is a field's, or every 2^k-th point of it an
/// axis.
class SideBox {
 public:
  explicit SideBox(double isovalue) : isovalue_(isovalue) {}

  /// `dims`: of the lattice; the box lies in it, without its upper ends.
  void open(const Index<3>& dims, const LatticeBox<3>& box);
  [[nodiscard]] std::size_t n_rows() const { return as_size(size_[1]) * as_size(size_[2]); }
  /// `step`: 2^k. Field: Model<3>, CoarseField<3> or FlatField<3>.
  template <typename Field>
  void fill_row(const Field& field, std::size_t row, std::int32_t step);

  [[nodiscard]] const LatticeBox<3>& box() const { return box_; }
  [[nodiscard]] const Index<3>& dims() const { return dims_; }
  /// Of values above the isovalue in place of samples, x fastest. NaN: a hole.
  void set_sides(std::span<const float> values);

  /// Appends the critical nodes of a level with centres in a box, without its upper ends; the
  /// samples of their stars are in this one.
  void find(int level, const LatticeBox<3>& centres, std::vector<Index<3>>& found) const;

 private:
  enum Side : std::uint8_t { outside, inside, hole };

  void find_in_row(int level, const Index<3>& row, std::int32_t n,
                   std::vector<Index<3>>& found) const;
  [[nodiscard]] bool is_critical(const Diamond<3>& node) const;
  /// Whether both ends of the axis are samples, as far as one odd coordinate goes.
  [[nodiscard]] bool has_ends(int level, const Index<3>& q, std::size_t axis) const {
    return (q[axis] + 1) << level < dims_[axis];
  }
  [[nodiscard]] const std::uint8_t* at(const Index<3>& p) const {
    return sides_.data() + linear_index<3>(size_, p - box_.lower);
  }

  double isovalue_;
  Index<3> dims_;
  LatticeBox<3> box_;
  Index<3> size_;                    ///< Of the box, in samples.
  std::vector<std::uint8_t> sides_;  ///< Of its samples, x fastest.
};

}  // namespace lode::diamond
