#include "lode/models/diamond/persistent_nodes.h"

#include <vector>

#include "lode/models/diamond/persistent_search.h"

namespace lode::diamond {

Result<CriticalNodes> find_persistent_nodes(const Model<3>& model, const CriticalQuery& query,
                                            Progress& progress) {
  PersistentSearch<Model<3>> search(model, query, progress);
  if (!model.shape.has_cells()) return CriticalNodes{NodeSet<3>(model.shape)};
  return search.run([&](std::span<const Index<3>> bricks, const auto& see) -> Result<void> {
    see(SeenBricks<Model<3>>{model, model, bricks, {}});
    return {};
  });
}

Result<CriticalNodes> find_persistent_nodes(const CoarseField<3>& field, store::BlockCache& blocks,
                                            const CriticalQuery& query, Progress& progress) {
  PersistentSearch<CoarseField<3>> search(field, query, progress);
  if (!field.shape.has_cells()) return CriticalNodes{NodeSet<3>(field.shape)};
  FilePart<3> part(field, blocks, query.threads);
  const Index<3> chunk_dims = chunk_counts<3>(field.shape);
  return search.run([&](std::span<const Index<3>> bricks, const auto& see) -> Result<void> {
    std::vector<std::vector<Index<3>>> by_chunk(n_points<3>(chunk_dims));
    for (const Index<3>& brick : bricks)
      by_chunk[chunk_of_brick<3>(field.shape, brick)].push_back(brick);
    std::erase_if(by_chunk, [](const auto& some) { return some.empty(); });
    const auto position = [&](std::size_t i) {
      return point_of<3>(chunk_dims, chunk_of_brick<3>(field.shape, by_chunk[i].front()));
    };
    for (std::size_t i = 0; i < by_chunk.size(); ++i) {
      if (progress.is_cancelled()) return cancelled_error();
      if (search.has_tolerance()) {
        LODE_CHECK(part.load(position(i), by_chunk[i], {}));
        part.fill_beside();
      } else {
        LODE_CHECK(part.load_samples(position(i), by_chunk[i]));
      }
      if (i + 1 < by_chunk.size()) part.will_load(position(i + 1), by_chunk[i + 1]);
      see(SeenBricks<FlatField<3>>{part.samples(), part.model(), part.fine(), part.origin()});
      LODE_CHECK(search.check_size());
    }
    return {};
  });
}

}  // namespace lode::diamond
