#pragma once

// The models that the tests of this room are made for; a model joins by one line.

#include <gtest/gtest.h>

#include "tests/contract/diamond_contract.h"
#include "tests/contract/insertions_contract.h"
#include "tests/contract/midpoint_contract.h"
#include "tests/contract/split_contract.h"
#include "tests/contract/tetra_contract.h"

namespace lode::test {

using DelaunayPyramidContract = InsertionsContract<delaunay::InsertionRule::delaunay>;
using TernaryContract = InsertionsContract<delaunay::InsertionRule::split>;

/// Those that can be saved and opened.
using StoredModels = ::testing::Types<  //
    DiamondContract<2>,                 //
    DiamondContract<3>,                 //
    TetraContract,                      //
    DelaunayPyramidContract,            //
    TernaryContract>;

/// All that the engine refines.
using AllModels = ::testing::Types<  //
    DiamondContract<2>,              //
    DiamondContract<3>,              //
    TetraContract,                   //
    MidpointContract,                //
    DelaunayPyramidContract,         //
    TernaryContract,                 //
    SplitTableContract,              //
    SplitLabelsContract>;

}  // namespace lode::test
