#include "lode/core/label.h"

#include <gtest/gtest.h>

#include <string>

namespace lode {
namespace {

TEST(label, is_text_in_utf8_without_control_characters) {
  for (const std::string text :
       {"", "steel", "in let", "\xC3\xA9", "\xE2\x82\xAC \xF0\x9F\x94\xA5"}) {
    EXPECT_FALSE(label_fault(text)) << text;
    EXPECT_EQ(to_label(text), text);
  }
}

TEST(label, is_made_of_what_is_none) {
  struct Case {
    std::string text;
    std::string label;
  };
  for (const auto& [text, label] :
       {Case{"a\nb\x1b[31m", "a b [31m"}, Case{std::string("a\0b", 3), "a b"}, Case{"\x7f", " "},
        Case{"a\xC2\x85z", "a z"},                            // next line, of C1
        Case{"\xFF\xFE", "??"}, Case{"x\xC3", "x?"},          // cut off
        Case{"\xC0\xAF", "??"}, Case{"\xE0\x80\xAF", "???"},  // longer than need be
        Case{"\xED\xA0\x80", "???"},                          // half of a pair of UTF-16
        Case{"\xF4\x90\x80\x80", "????"}, Case{"\xE9t\xE9", "?t?"}}) {
    EXPECT_TRUE(label_fault(text)) << label;
    EXPECT_EQ(to_label(text), label);
    EXPECT_FALSE(label_fault(to_label(text)));
  }
}

TEST(label, that_is_too_long_is_cut_between_characters) {
  const std::string longest(kMaxLabelBytes, 'x');
  EXPECT_EQ(to_label(longest), longest);
  EXPECT_FALSE(label_fault(longest));
  EXPECT_TRUE(label_fault(longest + "x"));
  EXPECT_EQ(to_label(longest + "x"), longest.substr(3) + "...");
  std::string euros;
  for (int i = 0; i < 3000; ++i) euros += "\xE2\x82\xAC";
  const std::string label = to_label(euros);
  EXPECT_FALSE(label_fault(label));
  EXPECT_EQ(label.size(), 4095U);
  EXPECT_TRUE(label.ends_with("\xAC..."));
}

}  // namespace
}  // namespace lode
