#include "lode/models/diamond/finest_nodes.h"

#include <algorithm>

namespace lode::diamond {
namespace {

template <int D>
void add_node(const Index<D>& origin, const Diamond<D>& node, FinestNodes<D>& out) {
  const auto ends = axis_ends<D>(node);
  out.bisections.push_back({node.centre - origin, ends[0] - origin, ends[1] - origin});
  out.samples.push_back(node.centre - origin);
  for (const Index<D>& v : domain_vertices<D>(node)) out.samples.push_back(v - origin);
  if (node.tier == D - 1) return;
  for (const Index<D>& child : children<D>(node)) add_node<D>(origin, diamond_at<D>(child), out);
}

template <int D>
FinestNodes<D> find_nodes(const Index<D>& centre) {
  FinestNodes<D> result;
  const Diamond<D> node = diamond_at<D>(centre);
  if (node.level > 0) return result;
  add_node<D>(centre, node, result);
  const auto less = [](const Index<D>& a, const Index<D>& b) { return a.v < b.v; };
  std::sort(result.samples.begin(), result.samples.end(), less);
  result.samples.erase(std::unique(result.samples.begin(), result.samples.end()),
                       result.samples.end());
  return result;
}

}  // namespace

template <int D>
const FinestNodes<D>& finest_nodes(const Index<D>& centre) {
  static const std::vector<FinestNodes<D>> kNodes = [] {
    std::vector<FinestNodes<D>> all;
    for (std::size_t i = 0; i < power(4, D); ++i)
      all.push_back(find_nodes<D>(point_of<D>(all_equal<D>(4), i) + all_equal<D>(4)));
    return all;
  }();
  std::size_t index = 0;
  for (std::size_t i = as_size(D); i-- > 0;) index = index * 4 + as_size(centre[i] & 3);
  return kNodes[index];
}

template const FinestNodes<2>& finest_nodes<2>(const Index<2>&);
template const FinestNodes<3>& finest_nodes<3>(const Index<3>&);

}  // namespace lode::diamond
