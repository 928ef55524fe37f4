#include "lode/models/diamond/encode_blocks.h"
#include "lode/models/diamond/persist.h"
#include "lode/models/diamond/world_error.h"
#include "lode/store/writer.h"

namespace lode::diamond {

template <int D>
std::string model_name() {
  return D == 3 ? "diamond3d" : "diamond2d";
}

namespace {

template <int D>
Result<void> save_with(const Model<D>& model, const WorldErrors& worlds, const std::string& path,
                       Threads threads, Progress& progress) {
  const Metadata metadata{.info = model.info, .summary = summarize<D>(model)};
  LODE_TRY(auto writer, store::Writer::create(path, model_name<D>(), encode_metadata(metadata)));
  if (model.has_holes()) writer.require(store::kFeatureRemovedCells);
  if (!model.info.units.is_empty()) writer.require(store::kFeatureUnits);
  writer.set_early_metadata(encode_early_metadata(model.info, model.stats));
  const std::size_t n_chunks = n_points<D>(chunk_counts<D>(model.shape));
  for (std::size_t i = 0; i <= n_chunks; ++i) {
    const std::vector<BlockGroup<D>> groups =
        i < n_chunks ? chunk_blocks<D>(model.shape, chunk_at<D>(model.shape, i))
                     : coarse_blocks<D>(model.shape);
    LODE_CHECK(append_groups<D>(model, worlds, {}, groups, writer, threads, progress));
    progress.report("writing", static_cast<double>(i + 1) / static_cast<double>(n_chunks + 1));
  }
  const auto finished = writer.finish(progress);
  if (!finished) return finished.error();
  return {};
}

}  // namespace

template <int D>
Result<void> save(const Model<D>& model, const std::string& path, Threads threads,
                  Progress& progress) {
  if (!model.worlds.empty()) return save_with<D>(model, model.worlds, path, threads, progress);
  LODE_TRY(const WorldErrors worlds, compute_world_errors<D>(model, threads, progress));
  return save_with<D>(model, worlds, path, threads, progress);
}

template std::string model_name<2>();
template std::string model_name<3>();
template Result<void> save<2>(const Model<2>&, const std::string&, Threads, Progress&);
template Result<void> save<3>(const Model<3>&, const std::string&, Threads, Progress&);

}  // namespace lode::diamond
