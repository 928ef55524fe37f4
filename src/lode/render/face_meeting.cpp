#include "lode/render/face_meeting.h"

#include <bit>
#include <utility>

namespace lode {
namespace {

double cut_bits(double a) {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(a) & ~kCutBits);
}

LineOffset offset_of(const ViewVertex& vertex, const SightLine& line) {
  return {cut_bits(vertex.right - line.right - line.right_slope * vertex.depth),
          cut_bits(vertex.up - line.up - line.up_slope * vertex.depth)};
}

}  // namespace

bool is_tie_negative(const LineOffset& a, const LineOffset& b, std::uint64_t vertex_a,
                     std::uint64_t vertex_b) {
  if (a.v != b.v) return a.v < b.v;
  if (a.u != b.u) return a.u > b.u;
  return vertex_a > vertex_b;
}

bool meet_face(const VolumeView& view, const SightLine& line, std::uint32_t outer_face,
               MetFace& face) {
  face.corners = view.links().outer_faces[outer_face].corners;
  for (std::size_t i = 0; i < 3; ++i)
    face.offsets[i] = offset_of(view.vertices()[face.corners[i]], line);
  std::array<bool, 3> is_negative{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    const LineOffset& a = face.offsets[j];
    const LineOffset& b = face.offsets[k];
    face.edges[i] = a.u * b.v - b.u * a.v;
    is_negative[i] = face.edges[i] != 0 ? face.edges[i] < 0
                                        : is_tie_negative(a, b, face.corners[j], face.corners[k]);
  }
  if (is_negative[0] != is_negative[1] || is_negative[0] != is_negative[2]) return false;
  if (is_negative[0]) {
    for (double& edge : face.edges) edge = -edge;
    std::swap(face.edges[1], face.edges[2]);
    std::swap(face.offsets[1], face.offsets[2]);
    std::swap(face.corners[1], face.corners[2]);
  }
  double sum = 0;
  face.depth = face.level = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const ViewVertex& vertex = view.vertices()[face.corners[i]];
    face.depths[i] = vertex.depth;
    face.levels[i] = vertex.level;
    face.depth += face.edges[i] * vertex.depth;
    face.level += face.edges[i] * vertex.level;
    sum += face.edges[i];
  }
  if (sum > 0) {
    face.depth /= sum;
    face.level /= sum;
  }
  return true;
}

}  // namespace lode
