#include <algorithm>
#include <memory>
#include <utility>

#include "lode/models/tetra_mt/base_blocks.h"
#include "lode/models/tetra_mt/file_layout.h"
#include "lode/models/tetra_mt/page_blocks.h"
#include "lode/models/tetra_mt/page_source.h"
#include "lode/models/tetra_mt/persist.h"
#include "lode/store/reader.h"

namespace lode::tetra_mt {
namespace {

class BaseReader {
 public:
  BaseReader(const store::Reader& reader, const BaseCounts& counts, HierarchyHead& head)
      : reader_(reader), counts_(counts), head_(head) {}

  Result<void> run() {
    LODE_CHECK(check_memory());
    LODE_CHECK(read_parts(Kind::base_vertices, head_.shape.n_base_vertices,
                          [&](StreamReader& in, std::size_t n) { return read_vertices(in, n); }));
    LODE_CHECK(read_tetrahedra());
    LODE_CHECK(read_parts(Kind::roots, counts_.n_roots,
                          [&](StreamReader& in, std::size_t n) { return read_roots(in, n); }));
    const auto n_inside = std::ranges::count_if(head_.base, [&](const Tetrahedron& t) {
      return std::ranges::find(t, head_.outside()) == t.end();
    });
    if (static_cast<std::uint64_t>(n_inside) != head_.n_base_cells)
      return fail("{}: expected {} cells of the base, got {}", reader_.path(), head_.n_base_cells,
                  n_inside);
    return read_front();
  }

 private:
  Result<void> check_memory() const {
    return check_base_memory(reader_,
                             head_.shape.n_base_vertices * (sizeof(Vec3d) + sizeof(double)) +
                                 counts_.n_tetrahedra * kBaseTetrahedronBytes +
                                 counts_.n_roots * sizeof(std::uint32_t));
  }
  template <typename Read>
  Result<void> read_parts(Kind kind, std::uint64_t n, const Read& read) {
    return tetra_mt::read_parts(
        reader_, n, [&](std::uint32_t part) { return key_of(kind, part); }, read);
  }
  Result<void> read_vertices(StreamReader& in, std::size_t n) {
    LODE_TRY(const auto coordinates, read_numbers(in, n, 3, head_.shape.has_narrow_positions));
    for (std::size_t i = 0; i < n; ++i)
      head_.base_positions.push_back(
          {{coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]}});
    return {};
  }
  Result<void> read_tetrahedra() {
    const auto key = key_of(Kind::base_tetrahedra, 0);
    LODE_TRY(const auto bytes, read_block(reader_, key));
    LODE_TRY(auto base, decode_base(bytes, counts_.n_tetrahedra, base_limits_of(head_),
                                    reader_.path() + ": " + store::describe(key)));
    head_.base = std::move(base.corners);
    head_.base_makers = std::move(base.makers);
    head_.base_regions = std::move(base.regions);
    return {};
  }
  Result<void> read_front() {
    const auto key = key_of(Kind::front, 0);
    LODE_TRY(const auto bytes, read_block(reader_, key));
    FrontNodes front{.nodes = front_nodes_of(head_.base_makers), .boxes = {}, .region_masks = {}};
    LODE_CHECK(decode_front(bytes, reader_.path() + ": " + store::describe(key),
                            front_base_of(head_), BoxCodes(head_.lower, head_.upper),
                            head_.shape.n_regions, front));
    head_.front = std::make_shared<const FrontNodes>(std::move(front));
    return {};
  }
  Result<void> read_roots(StreamReader& in, std::size_t n) {
    LODE_TRY(const auto roots, read_differences_of(in, n));
    for (const std::uint32_t root : roots) {
      if (root >= head_.shape.n_nodes || (!head_.roots.empty() && root <= head_.roots.back()))
        return fail("{}: expected nodes that ascend, up to {}, got {}", in.what(),
                    head_.shape.n_nodes, root);
      head_.roots.push_back(root);
    }
    return {};
  }

  const store::Reader& reader_;
  BaseCounts counts_;
  HierarchyHead& head_;
};

}  // namespace

bool is_model_of(const std::string& path) {
  const auto name = store::Reader::model_of(path);
  return name && *name == kModelName;
}

Result<OpenedHierarchy> open(const std::string& path) {
  LODE_TRY(auto opened, store::Reader::open(path));
  const auto reader = std::make_shared<const store::Reader>(std::move(opened));
  if (reader->model() != kModelName)
    return fail("{}: expected the model {}, got {}", path, kModelName, reader->model());
  BaseCounts counts;
  LODE_TRY(HierarchyHead head, decode_head(reader->metadata(), path, counts));
  LODE_CHECK(BaseReader(*reader, counts, head).run());
  const auto source = std::make_shared<const PageSource>(reader, head);
  LODE_CHECK(source->check());
  PackedHierarchy::Load load{
      [source](std::uint32_t page) { return source->links(page); },
      [source](std::size_t field, const HierarchyHead& own) { return source->base(field, own); },
      [source](std::size_t field, std::uint32_t page, const PageTree& tree, const FieldBase& base) {
        return source->field(field, page, tree, base);
      },
      [source](std::size_t field, std::uint32_t page, const FieldBase& base) {
        return source->world_errors(field, page, base);
      }};
  OpenedHierarchy result{.hierarchy = PackedHierarchy(std::move(head), std::move(load)),
                         .gradients = {},
                         .mesh_vertices = {},
                         .reads = [reader] {
                           return FileReads{reader->reads().n_bytes, reader->file_size()};
                         }};
  if (source->is_lean()) return result;
  result.gradients = [source](std::size_t field, std::uint32_t page) {
    return source->gradients(field, page);
  };
  result.mesh_vertices = [source] { return source->mesh_vertices(); };
  return result;
}

}  // namespace lode::tetra_mt
