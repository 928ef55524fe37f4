#pragma once

#include "lode/models/diamond/cell_field.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// A model's samples as the checks see them; `model` must outlive this.
template <int D>
class ModelSamples final : public FieldSamples {
 public:
  explicit ModelSamples(const Model<D>& model) : model_(model) {}
  [[nodiscard]] const RegularGrid& grid() const override { return model_.info.grid; }
  [[nodiscard]] double sample(const Index3& index) const override;
  void find_corners(const Index3& even, const Index3& step,
                    std::array<double, 8>& values) const override;

 private:
  const Model<D>& model_;
};

extern template class ModelSamples<2>;
extern template class ModelSamples<3>;

}  // namespace lode::diamond
