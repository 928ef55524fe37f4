#pragma once

namespace lode {

/// Prints the broken expectation and aborts. Called by LODE_EXPECTS only.
[[noreturn]] void broken_expectation(const char* condition, const char* file, int line);

}  // namespace lode

/// Programmer misuse ends the program; bad data never does (see Result).
#define LODE_EXPECTS(condition) \
  ((condition) ? void(0) : ::lode::broken_expectation(#condition, __FILE__, __LINE__))
