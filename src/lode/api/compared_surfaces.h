#pragma once

#include <cstdint>
#include <optional>

#include "lode/api/verify_report.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"

namespace lode {

// Checks of one surface against another; `whose` the other one is.

/// Rounding, in the file and by other choices of the origin: two units in the last place of
/// float32, world units.
[[nodiscard]] double file_rounding(const Surface& a, const Surface& b);

/// The triangles of one isovalue; all vertices. Vertices have isovalues.
[[nodiscard]] Surface part_of(const Surface& surface, double isovalue);

/// Compares what kinds of pieces there are.
void add_pieces(const Surface& surface, const Surface& other, const char* whose, Threads threads,
                VerifyReport& report);

/// The pieces of a surface that was simplified in a band are some of those before; others went.
void add_kept_pieces(const Surface& surface, const Surface& before, Threads threads,
                     VerifyReport& report);

/// Measures how far the two are from each other, of each isovalue by itself.
[[nodiscard]] Result<void> add_distance(const Surface& surface, const Surface& other,
                                        const char* whose, double max_distance, Threads threads,
                                        Progress& progress, VerifyReport& report);

/// Says how far a surface and the level set at full resolution are from each other, where nothing
/// is promised of that. `accuracy`: DistanceOptions'.
[[nodiscard]] Result<void> note_distance(const Surface& surface, const Surface& level_set,
                                         double accuracy, Threads threads, Progress& progress,
                                         VerifyReport& report);
[[nodiscard]] const char* level_set_distance_name();

enum class MayDrop : std::uint8_t { no, yes };

/// Whether pieces of a simplified surface face as before, some of which it may have dropped: closed
/// ones by their volumes, large open ones, and all together, by what is near. `distance`: that it
/// was to keep; without one, edges say about how far it may be. What is small beside a distance may
/// face any way but of closed pieces.
[[nodiscard]] Result<void> add_turning(const Surface& surface, const Surface& before,
                                       MayDrop may_drop, std::optional<double> distance,
                                       Threads threads, Progress& progress, VerifyReport& report);

}  // namespace lode
