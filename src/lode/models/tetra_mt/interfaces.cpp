#include "lode/models/tetra_mt/interfaces.h"

#include <algorithm>
#include <bit>

namespace lode::tetra_mt {
namespace {

std::uint64_t place_bit(int place) { return std::uint64_t{1} << place; }

void clear(const Star& star, Interfaces& found) {
  found.kind = Interfaces::Kind::none;
  found.n_faces = 0;
  found.on = 0;
  found.curves = 0;
  for (int i = 0; i < star.n_link; ++i) found.beside[static_cast<std::size_t>(i)] = 0;
}

void add_face(Interfaces& found, int a, int b, int triangle, int other) {
  const auto byte = [](int x) { return static_cast<std::uint8_t>(x); };
  found.faces[static_cast<std::size_t>(found.n_faces++)] = {{byte(a), byte(b)},
                                                            {byte(triangle), byte(other)}};
  found.beside[static_cast<std::size_t>(a)] |= place_bit(b);
  found.beside[static_cast<std::size_t>(b)] |= place_bit(a);
  found.on |= place_bit(a) | place_bit(b);
}

std::uint64_t corners_of(const Star& star, int triangle) {
  const auto& t = star.triangles[static_cast<std::size_t>(triangle)];
  return place_bit(t[0]) | place_bit(t[1]) | place_bit(t[2]);
}

bool is_connected(const Interfaces& found) {
  std::uint64_t reached = found.on & (~found.on + 1);
  for (std::uint64_t last = 0; reached != last;) {
    last = reached;
    for (std::uint64_t left = reached; left != 0; left &= left - 1)
      reached |= found.beside[static_cast<std::size_t>(std::countr_zero(left))];
  }
  return reached == found.on;
}

/// Whether all that leaves one vertex of the graph reaches the other, through none of their like.
bool are_poles(const Interfaces& found, int a, int b) {
  const std::uint64_t from_a = found.beside[static_cast<std::size_t>(a)];
  if (std::popcount(from_a) != std::popcount(found.beside[static_cast<std::size_t>(b)]))
    return false;
  for (std::uint64_t left = from_a; left != 0; left &= left - 1) {
    const InterfaceWalk disc = walk(found, a, std::countr_zero(left));
    if (disc.places[static_cast<std::size_t>(disc.n - 1)] != b) return false;
  }
  return true;
}

/// On a sphere, a cycle parts two discs; arcs between two poles part discs all round a line.
Interfaces::Kind kind_of(const Interfaces& found) {
  using Kind = Interfaces::Kind;
  if (found.on == 0) return Kind::none;
  if (!is_connected(found)) return Kind::corner;
  if (found.curves == 0) return Kind::sheet;
  if (std::popcount(found.curves) != 2) return Kind::corner;
  const int a = std::countr_zero(found.curves);
  const int b = std::countr_zero(found.curves & (found.curves - 1));
  return are_poles(found, a, b) ? Kind::curve : Kind::corner;
}

}  // namespace

void find_boundary(const Star& star, Interfaces& found) {
  clear(star, found);
  if (!star.is_on_boundary()) return;
  for (int i = 0; i < star.n_triangles; ++i) {
    if (!star.has(i, star.outside)) continue;
    const auto& t = star.triangles[static_cast<std::size_t>(i)];
    const int a = t[0] == star.outside ? t[1] : t[0];
    add_face(found, a, t[0] + t[1] + t[2] - star.outside - a, i, i);
  }
  found.kind = Interfaces::Kind::sheet;
}

void find_interfaces(const Star& star, std::span<const std::uint32_t> labels, Interfaces& found) {
  clear(star, found);
  const std::span<const std::uint32_t> own =
      labels.first(static_cast<std::size_t>(star.n_triangles));
  if (std::ranges::all_of(own, [&](std::uint32_t label) { return label == own.front(); })) return;
  for (int i = 0; i < star.n_triangles; ++i) {
    const std::uint64_t corners = corners_of(star, i);
    for (int j = i + 1; j < star.n_triangles; ++j) {
      if (labels[static_cast<std::size_t>(i)] == labels[static_cast<std::size_t>(j)]) continue;
      const std::uint64_t common = corners & corners_of(star, j);
      if (std::popcount(common) != 2 || found.n_faces == Interfaces::kMaxFaces) continue;
      add_face(found, std::countr_zero(common), std::countr_zero(common & (common - 1)), i, j);
    }
  }
  for (int i = 0; i < star.n_link; ++i)
    if (found.has(found.on, i) && std::popcount(found.beside[static_cast<std::size_t>(i)]) != 2)
      found.curves |= place_bit(i);
  found.kind = kind_of(found);
}

InterfaceWalk walk(const Interfaces& interfaces, int first, int second) {
  InterfaceWalk result;
  const auto add = [&](int place) {
    result.places[static_cast<std::size_t>(result.n++)] = static_cast<std::uint8_t>(place);
  };
  add(first);
  add(second);
  int last = first;
  for (int at = second; !interfaces.has(interfaces.curves, at) && result.n < Star::kMaxLink;) {
    const std::uint64_t ahead = interfaces.beside[static_cast<std::size_t>(at)] & ~place_bit(last);
    last = at;
    at = std::countr_zero(ahead);
    if (at == first) break;
    add(at);
  }
  return result;
}

bool goes_along(const Interfaces& interfaces, int kept) {
  switch (interfaces.kind) {
    case Interfaces::Kind::none: return true;
    case Interfaces::Kind::sheet: return interfaces.has(interfaces.on, kept);
    case Interfaces::Kind::curve: return interfaces.has(interfaces.curves, kept);
    case Interfaces::Kind::corner: break;
  }
  return false;
}

bool keeps_interfaces(const Star& star, const Interfaces& interfaces, int kept, const Star& other,
                      const Interfaces& other_interfaces) {
  if (interfaces.kind == Interfaces::Kind::none) return true;
  const std::uint64_t edge_link = interfaces.beside[static_cast<std::size_t>(kept)];
  std::array<int, Star::kMaxLink> here;  // by place in the other's link
  for (int j = 0; j < other.n_link; ++j) {
    here[static_cast<std::size_t>(j)] = -1;
    if (!other_interfaces.has(other_interfaces.on, j)) continue;
    for (std::uint64_t left = interfaces.on; left != 0; left &= left - 1) {
      const int i = std::countr_zero(left);
      if (star.link[static_cast<std::size_t>(i)] == other.link[static_cast<std::size_t>(j)])
        here[static_cast<std::size_t>(j)] = i;
    }
    const int i = here[static_cast<std::size_t>(j)];
    if (i < 0) continue;
    if (!interfaces.has(edge_link, i)) return false;
    if (interfaces.kind == Interfaces::Kind::curve && interfaces.has(interfaces.curves, i) &&
        other_interfaces.has(other_interfaces.curves, j))
      return false;
  }
  for (int f = 0; f < other_interfaces.n_faces; ++f) {
    const auto& edge = other_interfaces.faces[static_cast<std::size_t>(f)].edge;
    const int a = here[edge[0]];
    const int b = here[edge[1]];
    if (a >= 0 && b >= 0 && interfaces.has(interfaces.beside[static_cast<std::size_t>(a)], b))
      return false;
  }
  return true;
}

}  // namespace lode::tetra_mt
