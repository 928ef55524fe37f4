#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "lode/api/session.h"

namespace lode {

/// What a session's batches add up to when its first query is answered. A failure after two
/// minutes.
inline SurfaceMirror take_settled(Session& session) {
  SurfaceMirror mirror;
  const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (std::chrono::steady_clock::now() < until) {
    const auto batch = session.take();
    if (!batch) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      continue;
    }
    if (batch->fault) {
      ADD_FAILURE() << batch->fault->message;
      return mirror;
    }
    mirror.apply(batch->change);
    if (batch->standing.is_settled) return mirror;
  }
  ADD_FAILURE() << "no answer came";
  return mirror;
}

}  // namespace lode
