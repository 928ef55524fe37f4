#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "input.h"
#include "lode/api/tetra_dataset.h"

namespace lode::cli {

/// Behind the name of a vector: its three components.
inline constexpr std::string_view kVectorEnd = ":xyz";

/// Whether what is read has a field of just this name.
using IsField = std::function<bool(const std::string&)>;
[[nodiscard]] IsField is_field_of(const TetraInfo& info);

/// NAME:x as NAME:0, and so on, also in front of " at TIME".
[[nodiscard]] std::string numbered_component(const std::string& name);

/// The scalars that a name as typed stands for: a field's own name is that field; else NAME:xyz are
/// three, and NAME:x is NAME:0. Each may have " at TIME" behind it.
[[nodiscard]] std::vector<std::string> scalars_of(const std::string& name, const IsField& is_field);

/// Of --with as typed, without "all".
[[nodiscard]] std::vector<std::string> scalars_of_with(const ReadingArguments& reading,
                                                       const IsField& is_field);
[[nodiscard]] bool wants_all(const ReadingArguments& reading);

/// Places of fields of a .lode file by their names, `NAME at TIME` among them; an empty name is the
/// first. All are of one time: that of the first with steps, of which `step` says the number, from
/// 0 in order of time, a field without a time before all (none: 0). Fields without any time are as
/// they are. Fails, naming it, where a field lacks that time.
[[nodiscard]] Result<std::vector<std::size_t>> named_fields(const TetraInfo& info,
                                                            const std::vector<std::string>& names,
                                                            const std::string& step);

/// The vector that deforms a mesh, by the places of its components, and those of further fields
/// that are read for it alone.
struct WarpPlaces {
  std::array<std::size_t, 3> vector{};
  std::vector<std::size_t> hidden{};
};

/// Which fields are read, and which of them for --warp.
struct ReadFields {
  TetraFieldUse use{};
  std::optional<WarpPlaces> warp{};
};
/// Of a .lode file.
[[nodiscard]] Result<ReadFields> fields_of(const TetraInfo& info, const ReadingArguments& reading);
/// Of a mesh with just the fields that were asked for, the measured one first.
[[nodiscard]] Result<ReadFields> fields_of_built(const TetraInfo& info,
                                                 const ReadingArguments& reading);

}  // namespace lode::cli
