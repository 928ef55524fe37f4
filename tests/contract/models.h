#pragma once

// The models that the tests of this room are made for; a model joins by one line.

#include <gtest/gtest.h>

#include "tests/contract/diamond_contract.h"
#include "tests/contract/insertions_contract.h"
#include "tests/contract/midpoint_contract.h"
#include "tests/contract/split_contract.h"
#include "tests/contract/tetra_contract.h"

namespace lode::test {

using DelaunayPyramidContract = InsertionsContract<insertions::Model::delaunay_pyramid>;
using TernaryContract = InsertionsContract<insertions::Model::ternary_triangulation>;
using PointPyramidContract = InsertionsContract<insertions::Model::delaunay_pyramid, true>;
using ImplicitPointsContract =
    InsertionsContract<insertions::Model::implicit_delaunay_pyramid, true>;
using ImplicitPyramidContract = InsertionsContract<insertions::Model::implicit_delaunay_pyramid>;

/// Those that can be saved and opened.
using StoredModels = ::testing::Types<  //
    DiamondContract<2>,                 //
    DiamondContract<3>,                 //
    TetraContract,                      //
    MidpointContract<1>,                //
    MidpointContract<2>,                //
    DelaunayPyramidContract,            //
    TernaryContract,                    //
    PointPyramidContract,               //
    ImplicitPointsContract,             //
    ImplicitPyramidContract>;

/// All that the engine refines.
using AllModels = ::testing::Types<  //
    DiamondContract<2>,              //
    DiamondContract<3>,              //
    TetraContract,                   //
    MidpointContract<1>,             //
    MidpointContract<2>,             //
    DelaunayPyramidContract,         //
    TernaryContract,                 //
    PointPyramidContract,            //
    ImplicitPointsContract,          //
    ImplicitPyramidContract,         //
    SplitTableContract,              //
    SplitLabelsContract>;

}  // namespace lode::test
