#pragma once

#include <array>
#include <cstdint>

#include "lode/models/tetra_mt/box_steps.h"
#include "lode/models/tetra_mt/child_links.h"
#include "lode/models/tetra_mt/far_links.h"
#include "lode/models/tetra_mt/maker_codes.h"
#include "lode/models/tetra_mt/mask_codes.h"
#include "lode/models/tetra_mt/number_models.h"
#include "lode/models/tetra_mt/position_codes.h"
#include "lode/models/tetra_mt/value_codes.h"

namespace lode::tetra_mt {

/// Of all that a page has for all fields: docs/format.md, section 7.
struct LinkModels {
  static constexpr std::uint32_t kFew = 6;  ///< Contexts tell apart counts up to this.

  struct Counts {
    std::array<CountModel<4>, 5> children;
    std::array<CountModel<4>, 13> discovered;
    std::array<CountModel<4>, kFew + 1> parents;
    BitModel is_odd;
    std::array<CountModel<5>, 11> makers;
  };
  struct Targets {
    std::array<BitModel, kFew + 1> is_parent;
    /// By how many parents there are, place, and whether it is near.
    std::array<std::array<std::array<BitModel, 2>, kFew + 1>, kFew + 1> which_parent;
    std::array<BitModel, kFew + 1> is_shared;
    BitModel is_near;
    NumberModel near;
  };
  struct Regions {
    CountModel<5> counts;
    BitModel is_other;
    WideModel numbers;
  };

  PositionModels positions;
  Counts counts;
  FarModels far;
  ChildModels children;
  BoxModels boxes;
  Targets targets;
  MakerModels makers;
  Regions regions;
  MaskModels masks;
};

/// Of all that it has for one field.
struct FieldModels {
  static constexpr std::uint32_t kFew = 4;

  struct Excess {
    BitModel is_any;
    NumberModel size;
  };
  struct Facts {
    std::array<SymbolModel<5>, 2> octaves;  ///< By whether it discovers any.
    std::array<SymbolModel<2>, 32> quarters;
    std::array<std::array<NumberModel, 12>, 2> lows;   ///< And by the error;
    std::array<std::array<NumberModel, 13>, 2> highs;  ///< by how far it is down to the low.
    /// By fact, whether it discovers any of other pages, how many, and whether its value is beyond
    /// what these state.
    std::array<std::array<std::array<std::array<Excess, 2>, kFew + 1>, 2>, 3> excess;
  };

  ValueModels values;
  Facts facts;
};

}  // namespace lode::tetra_mt
