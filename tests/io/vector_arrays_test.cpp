#include "lode/io/vector_arrays.h"

#include <gtest/gtest.h>

namespace lode::io {
namespace {

/// As "name: numbers; ...".
std::string told(const std::string& first, const std::vector<std::string>& names) {
  std::string text;
  for (const ArrayOfFields& array : arrays_of_fields(first, names)) {
    text += text.empty() ? array.name + ":" : "; " + array.name + ":";
    for (const int field : array.fields) text += " " + std::to_string(field);
  }
  return text;
}

TEST(vector_arrays, are_three_components_that_follow_each_other) {
  EXPECT_EQ(told("p", {"u:0", "u:1", "u:2"}), "u: 0 1 2");
  EXPECT_EQ(told("p", {"T", "u:0", "u:1", "u:2", "w:0", "w:1", "w:2", "q"}),
            "T: 0; u: 1 2 3; w: 4 5 6; q: 7");
  EXPECT_EQ(told("p", {"u:0", "u:1"}), "u:0: 0; u:1: 1");
  EXPECT_EQ(told("p", {"u:0", "u:2", "u:1"}), "u:0: 0; u:2: 1; u:1: 2");
  EXPECT_EQ(told("p", {"u:0", "u:1", "w:2"}), "u:0: 0; u:1: 1; w:2: 2");
  EXPECT_EQ(told("p", {":0", ":1", ":2"}), ":0: 0; :1: 1; :2: 2");
  EXPECT_EQ(told("p", {}), "");
}

TEST(vector_arrays, are_no_longer_ones) {
  EXPECT_EQ(told("p", {"s:0", "s:1", "s:2", "s:3", "s:4", "s:5"}),
            "s:0: 0; s:1: 1; s:2: 2; s:3: 3; s:4: 4; s:5: 5");
}

TEST(vector_arrays, may_begin_with_the_first_field) {
  EXPECT_EQ(told("u:0", {"u:1", "u:2", "T"}), "u: -1 0 1; T: 2");
  EXPECT_EQ(told("u:0", {"T", "u:1", "u:2"}), "T: 0; u:1: 1; u:2: 2");
  EXPECT_EQ(told("u:0", {"u:1", "u:2", "u:3"}), "u:1: 0; u:2: 1; u:3: 2");
}

TEST(vector_arrays, have_names_of_their_own) {
  EXPECT_EQ(told("u", {"u:0", "u:1", "u:2"}), "u:xyz: 0 1 2");
  EXPECT_EQ(told("p", {"u", "u:0", "u:1", "u:2"}), "u: 0; u:xyz: 1 2 3");
}

}  // namespace
}  // namespace lode::io
