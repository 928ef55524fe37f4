#pragma once

// The models that the tests of this room are made for; a model joins by one line.

#include <gtest/gtest.h>

#include "tests/contract/diamond_contract.h"
#include "tests/contract/midpoint_contract.h"
#include "tests/contract/pyramid_contract.h"
#include "tests/contract/split_contract.h"
#include "tests/contract/tetra_contract.h"

namespace lode::test {

/// Those that can be saved and opened.
using StoredModels = ::testing::Types<  //
    DiamondContract<2>,                 //
    DiamondContract<3>,                 //
    TetraContract,                      //
    PyramidContract>;

/// All that the engine refines.
using AllModels = ::testing::Types<  //
    DiamondContract<2>,              //
    DiamondContract<3>,              //
    TetraContract,                   //
    MidpointContract,                //
    PyramidContract,                 //
    SplitTableContract,              //
    SplitLabelsContract>;

}  // namespace lode::test
