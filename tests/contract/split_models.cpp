#include "tests/contract/split_models.h"

#include <algorithm>
#include <map>
#include <set>

namespace lode::test {

void SplitModel::add_base(std::vector<NodeId>& out) const {
  for (std::size_t i = 0; i < hierarchy_->splits.size(); ++i)
    if (hierarchy_->forest_parents[hierarchy_->label(i)] == kNoLabel)
      out.push_back(node_of(hierarchy_->label(i)));
}

void SplitModel::add_children(NodeId node, std::vector<NodeId>& out) const {
  for (const Label child : hierarchy_->split(label_of(node)).children)
    if (hierarchy_->is_node(child)) out.push_back(node_of(child));
}

std::uint64_t SplitModel::apply(NodeId node) {
  const Split& split = hierarchy_->split(label_of(node));
  mesh_.replace(split.before, split.after);
  return split.after.size() - split.before.size();
}

std::uint64_t SplitModel::undo(NodeId node) {
  const Split& split = hierarchy_->split(label_of(node));
  mesh_.replace(split.after, split.before);
  return split.after.size() - split.before.size();
}

ParentTable find_parents(const SplitHierarchy& hierarchy) {
  std::map<Triangle, Label> makers;
  for (std::size_t i = 0; i < hierarchy.splits.size(); ++i)
    for (const Triangle& triangle : hierarchy.splits[i].after)
      makers.emplace(triangle, hierarchy.label(i));
  ParentTable result;
  for (const Split& split : hierarchy.splits) {
    std::set<Label> parents;
    for (const Triangle& triangle : split.before)
      if (const auto maker = makers.find(triangle); maker != makers.end())
        parents.insert(maker->second);
    result.emplace_back(parents.begin(), parents.end());
  }
  return result;
}

void SplitTable::add_parents(NodeId node, std::vector<NodeId>& out) const {
  for (const Label parent : (*parents_)[hierarchy().place(label_of(node))])
    out.push_back(node_of(parent));
}

void SplitLabels::add_parents(NodeId node, std::vector<NodeId>& out) const {
  const Label v = label_of(node);
  const std::vector<Label>& makers = hierarchy().forest_parents;
  if (!mesh().has_vertex(v)) {
    if (makers[v] != kNoLabel) out.push_back(node_of(makers[v]));
    return;
  }
  const std::vector<Label> around = mesh().neighbours(v);
  if (around.back() > v) {
    for (const Label w : around)
      if (w > v) out.push_back(node_of(w));
    return;
  }
  std::set<Label> made_by{makers[v]};
  for (const Label w : around) made_by.insert(makers[w]);
  made_by.erase(kNoLabel);
  for (const Label parent : made_by) out.push_back(node_of(parent));
}

bool SplitLabels::can_split(NodeId node) const {
  const Label v = label_of(node);
  return mesh().has_vertex(v) && mesh().neighbours(v).back() < v;
}

bool SplitLabels::can_collapse(NodeId node) const {
  const Label v = label_of(node);
  const auto [a, b] = hierarchy().split(v).children;
  const std::vector<Label> around = mesh().neighbours(a);
  if (!std::binary_search(around.begin(), around.end(), b)) return false;
  // The ends themselves were made by v; what nothing made, roots, has a label above all.
  const auto may_stay = [&](Label w) { return hierarchy().forest_parents[w] >= v; };
  const std::vector<Label> beyond = mesh().neighbours(b);
  return std::all_of(around.begin(), around.end(), may_stay) &&
         std::all_of(beyond.begin(), beyond.end(), may_stay);
}

}  // namespace lode::test
