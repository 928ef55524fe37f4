// Files that are written piece by piece are those of the whole surface, byte for byte.
#include "lode/io/surface_stream.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "lode/io/patched_spool.h"
#include "tests/io/surface_fixtures.h"

namespace lode::io {
namespace {

/// Cells begin .. end - 1 as a piece behind n_before vertices. Cells must name vertices for the
/// first time in their order.
template <typename Cell>
SurfacePiece piece_of(const Surface& whole, const std::vector<Cell>& cells, std::size_t begin,
                      std::size_t end, std::uint32_t n_before) {
  SurfacePiece piece;
  piece.first_new = n_before;
  piece.surface.origin = whole.origin;
  std::uint32_t n_after = n_before;
  std::vector<std::uint32_t> earlier;
  for (std::size_t i = begin; i < end; ++i)
    for (const std::uint32_t v : cells[i]) {
      n_after = std::max(n_after, v + 1);
      if (v < n_before && std::ranges::find(earlier, v) == earlier.end()) earlier.push_back(v);
    }
  piece.earlier = earlier;
  std::map<std::uint32_t, std::uint32_t> place;
  const auto take = [&](std::uint32_t v) {
    place[v] = static_cast<std::uint32_t>(piece.surface.positions.size());
    piece.surface.positions.push_back(whole.positions[v]);
    if (!whole.normals.empty()) piece.surface.normals.push_back(whole.normals[v]);
    if (!whole.isovalues.empty()) piece.surface.isovalues.push_back(whole.isovalues[v]);
  };
  for (std::uint32_t v = n_before; v < n_after; ++v) take(v);
  for (const std::uint32_t v : earlier) take(v);
  for (std::size_t i = begin; i < end; ++i) {
    Cell cell = cells[i];
    for (std::uint32_t& v : cell) v = place.at(v);
    if constexpr (std::tuple_size_v<Cell> == 3)
      piece.surface.triangles.push_back(cell);
    else
      piece.surface.lines.push_back(cell);
  }
  return piece;
}

/// The whole in pieces of 1, 2, 4, ... cells, with empty ones between.
Result<void> add_pieces(const Surface& whole, SurfaceSink& sink) {
  const std::size_t n = whole.triangles.size() + whole.lines.size();
  LODE_CHECK(sink.add(piece_of(whole, whole.triangles, 0, 0, 0)));
  for (std::size_t begin = 0, step = 1; begin < n; begin += step, step *= 2) {
    const std::size_t end = std::min(n, begin + step);
    LODE_CHECK(sink.add(whole.lines.empty()
                            ? piece_of(whole, whole.triangles, begin, end, sink.n_vertices())
                            : piece_of(whole, whole.lines, begin, end, sink.n_vertices())));
    LODE_CHECK(sink.add(piece_of(whole, whole.triangles, 0, 0, sink.n_vertices())));
  }
  return {};
}

/// The isovalue of each piece is that of its first vertex.
Surface torus_of_one_isovalue(std::uint32_t n) {
  Surface torus = make_torus(n);
  std::ranges::fill(torus.isovalues, 1000.1F);
  return torus;
}

const SurfaceWriteOptions kOptions{.comment = "in <pieces>", .frame = Frame::unknown};

class surface_stream : public testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] std::string extension() const { return GetParam(); }

  void expect_same_file(const Surface& surface, std::uint64_t memory_bytes) const {
    const std::string whole = temporary_path("whole") + extension();
    const std::string streamed = temporary_path("streamed") + extension();
    Progress progress;
    const auto written = write_surface(whole, surface, kOptions, progress);
    ASSERT_TRUE(written) << written.error().message;
    auto stream = stream_surface(streamed, memory_bytes, {2}, progress);
    ASSERT_TRUE(stream) << stream.error().message;
    const auto added = add_pieces(surface, **stream);
    ASSERT_TRUE(added) << added.error().message;
    EXPECT_FALSE(std::filesystem::exists(streamed));
    const auto finished = (*stream)->finish(kOptions);
    ASSERT_TRUE(finished) << finished.error().message;
    EXPECT_TRUE(bytes_of(streamed) == bytes_of(whole));
    ::unlink(whole.c_str());
    ::unlink(streamed.c_str());
  }
};

TEST_P(surface_stream, gives_the_file_of_the_whole) {
  ASSERT_TRUE(can_stream(extension()));
  Surface surface = torus_of_one_isovalue(40);
  for (const std::uint64_t memory_bytes : {0U, 5000U, 1U << 24}) {
    expect_same_file(surface, memory_bytes);
    Surface bare = surface;
    bare.normals.clear();
    bare.isovalues.clear();
    expect_same_file(bare, memory_bytes);
    expect_same_file({}, memory_bytes);
  }
}

/// Several threads fill in records, of which each takes thousands.
TEST_P(surface_stream, gives_the_same_file_for_any_number_of_threads) {
  const Surface surface = torus_of_one_isovalue(120);
  ASSERT_GT(surface.triangles.size(), 20000U);
  const std::string path = temporary_path("threads") + extension();
  Progress progress;
  std::vector<std::string> files;
  for (const int n : {1, 2, 5}) {
    SurfaceWriteOptions options = kOptions;
    options.threads = {n};
    ASSERT_TRUE(write_surface(path, surface, options, progress));
    files.push_back(bytes_of(path));
    for (const std::uint64_t memory_bytes : {0U, 1U << 24}) {
      auto stream = stream_surface(path, memory_bytes, {n}, progress);
      ASSERT_TRUE(stream && add_pieces(surface, **stream) && (*stream)->finish(options));
      files.push_back(bytes_of(path));
    }
  }
  for (const std::string& file : files) EXPECT_TRUE(file == files.front());
  ::unlink(path.c_str());
}

TEST_P(surface_stream, keeps_an_origin_or_says_why_not) {
  Surface surface = torus_of_one_isovalue(7);
  surface.origin = {{1e9, 2, -3e7}};
  if (extension() != ".stl") return expect_same_file(surface, 100);
  Progress progress;
  const std::string path = temporary_path("far.stl");
  const auto stream = stream_surface(path, 100, {2}, progress);
  ASSERT_TRUE(stream);
  const auto added = add_pieces(surface, **stream);
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().message.find("float32"), std::string::npos) << added.error().message;
}

TEST_P(surface_stream, holds_lines_or_says_why_not) {
  Surface circle;
  for (const float x : {0.0F, 1.0F, 2.0F, 3.0F, 4.0F}) circle.positions.push_back({{x, x * x, 0}});
  circle.lines = {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 0}};
  if (can_hold_lines(extension())) return expect_same_file(circle, 10);
  Progress progress;
  const auto stream = stream_surface(temporary_path("line.stl"), 100, {2}, progress);
  ASSERT_TRUE(stream);
  EXPECT_FALSE(add_pieces(circle, **stream));
}

TEST_P(surface_stream, takes_normals_that_come_later) {
  if (extension() == ".stl") return;
  Surface surface = torus_of_one_isovalue(20);
  const std::string whole = temporary_path("whole") + extension();
  const std::string streamed = temporary_path("streamed") + extension();
  std::vector<VertexNormal> later;
  Surface before = surface;
  for (std::uint32_t v = 0; v < surface.positions.size(); v += 3) {
    later.push_back({v, surface.normals[v]});
    before.normals[v] = Vec3f{};
  }
  std::swap(later.front(), later.back());
  Progress progress;
  ASSERT_TRUE(write_surface(whole, surface, kOptions, progress));
  for (const std::uint64_t memory_bytes : {0U, 1U << 20}) {
    const auto stream = stream_surface(streamed, memory_bytes, {2}, progress);
    ASSERT_TRUE(stream && add_pieces(before, **stream));
    (*stream)->set_normals(later);
    ASSERT_TRUE((*stream)->finish(kOptions));
    EXPECT_TRUE(bytes_of(streamed) == bytes_of(whole));
  }
  ::unlink(whole.c_str());
  ::unlink(streamed.c_str());
}

TEST_P(surface_stream, leaves_nothing_when_it_is_not_finished_or_cancelled) {
  const std::string directory = temporary_path("left") + extension();
  std::filesystem::create_directory(directory);
  const std::string path = directory + "/surface" + extension();
  const Surface surface = torus_of_one_isovalue(9);
  {
    Progress progress;
    const auto stream = stream_surface(path, 0, {2}, progress);
    ASSERT_TRUE(stream && add_pieces(surface, **stream));
  }
  EXPECT_TRUE(std::filesystem::is_empty(directory));
  {
    Progress progress;
    const auto stream = stream_surface(path, 0, {2}, progress);
    ASSERT_TRUE(stream && add_pieces(surface, **stream));
    progress.cancel();
    EXPECT_FALSE((*stream)->finish(kOptions));
  }
  EXPECT_TRUE(std::filesystem::is_empty(directory));
  std::filesystem::remove_all(directory);
}

INSTANTIATE_TEST_SUITE_P(formats, surface_stream, testing::Values(".ply", ".stl", ".vtp"));

TEST(patched_spool, reads_what_was_written_and_replaced_wherever_it_lies) {
  std::vector<std::byte> expected(3'000'000);
  for (std::size_t i = 0; i < expected.size(); ++i)
    expected[i] = static_cast<std::byte>((i * 2654435761U) >> 13);
  PatchedSpool spool(testing::TempDir(), {2});
  for (std::size_t at = 0, n = 1; at < expected.size(); at += n, n = 3 * n + 1) {
    n = std::min(n, expected.size() - at);
    ASSERT_TRUE(spool.write(std::span(expected).subspan(at, n)));
  }
  std::vector<std::byte> changed = expected;
  for (const std::size_t at :
       {std::size_t{2'097'150}, std::size_t{0}, std::size_t{1'048'574}, expected.size() - 5}) {
    const std::vector<std::byte> other(5, std::byte{77});
    spool.replace(at, other);
    std::ranges::copy(other, changed.begin() + static_cast<std::ptrdiff_t>(at));
  }
  for (const std::size_t record : {1U, 12U, 28U}) {
    std::vector<std::byte> got;
    ASSERT_TRUE(spool.read(record, [&](std::span<const std::byte> bytes) -> Result<void> {
      got.insert(got.end(), bytes.begin(), bytes.end());
      return {};
    }));
    EXPECT_TRUE(got == changed) << record;
  }
}

TEST(patched_spool, is_empty_and_has_no_file_before_the_first_bytes) {
  const PatchedSpool spool("/nowhere/at/all", {1});
  bool is_read = false;
  ASSERT_TRUE(spool.read(1, [&](std::span<const std::byte>) -> Result<void> {
    is_read = true;
    return {};
  }));
  EXPECT_FALSE(is_read);
}

}  // namespace
}  // namespace lode::io
