// Files that are damaged, that name others, or claim what they do not have; and a reader of netCDF
// that crashes, hangs or says nonsense.
#include <hdf5.h>
#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <random>
#include <thread>

#include "lode/io/imported_raster.h"
#include "tests/io/height_reading.h"
#include "tests/io/netcdf_files.h"
#include "tests/oracles/trials.h"

namespace lode::io {
namespace {

using test::NetcdfFile;
using test::places;
using test::set_text;
using test::twelve;
using test::write_netcdf_file;

class damaged_netcdf : public test::HeightReading {
 protected:
  static NetcdfFile small(int format) {
    NetcdfFile file{.format = format,
                    .samples = twelve(25),
                    .x = places(10, 0.25, 4),
                    .y = places(47, -0.25, 3)};
    file.define = [](int nc, int z) { set_text(nc, z, "units", "m"); };
    if (format == NC_NETCDF4) file.chunk = {2, 3};
    return file;
  }
  [[nodiscard]] std::string bytes_of(int format) const {
    write_netcdf_file((*this)("whole.nc"), small(format));
    std::ifstream file((*this)("whole.nc"), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  [[nodiscard]] std::string write(const std::string& bytes) const {
    std::ofstream((*this)("damaged.nc"), std::ios::binary) << bytes;
    return (*this)("damaged.nc");
  }
  /// A file whose variable z is made by `make` of an open HDF5 file.
  template <typename Make>
  [[nodiscard]] std::string write_hdf5(const Make& make) const {
    const std::string path = (*this)("outside.nc");
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    make(file);
    H5Fclose(file);
    return path;
  }
  /// A program that is run for lode-raster-import.
  [[nodiscard]] std::string script(const std::string& lines) const {
    const std::string path = (*this)("importer");
    std::ofstream(path) << "#!/bin/sh\n" << lines << "\n";
    ::chmod(path.c_str(), 0700);
    return path;
  }
  [[nodiscard]] std::string failure_of(const std::string& lines) const {
    using std::chrono::milliseconds;
    Progress progress;
    const auto raster = import_raster((*this)("a.nc"), {}, progress,
                                      {.path = script(lines), .patience = milliseconds(400)});
    EXPECT_FALSE(raster);
    return raster ? "" : raster.error().message;
  }
};

constexpr std::array kFormatsOfDamage{0, NC_64BIT_DATA, NC_NETCDF4};

TEST_F(damaged_netcdf, is_refused_wherever_it_ends) {
  for (const int format : kFormatsOfDamage) {
    const std::string whole = bytes_of(format);
    std::mt19937 random(7);
    for (int i = 0; i < oracles::trials(12, 5); ++i) {
      // Up to the last sample, behind which HDF5 may have nothing that is missed.
      const std::size_t n = i == 0 ? whole.size() - 4 : 8 + random() % (whole.size() - 12);
      const std::string said = refusal(write(whole.substr(0, n)));
      EXPECT_EQ(said.find("crash"), std::string::npos) << said;
    }
  }
}

TEST_F(damaged_netcdf, never_ends_or_stops_this_program) {
  int n_read = 0;
  for (const int format : kFormatsOfDamage) {
    const std::string whole = bytes_of(format);
    std::mt19937 random(static_cast<std::uint32_t>(format) + 3);
    for (int i = 0; i < oracles::trials(80, 8); ++i) {
      std::string bytes = whole;
      for (int n = 1 + static_cast<int>(random() % 4); n > 0; --n)
        bytes[random() % bytes.size()] = static_cast<char>(random());
      const std::string path = write(bytes);
      Progress progress;
      const auto raster = read_heights(path, {}, progress);
      if (raster) {
        ++n_read;
        continue;
      }
      EXPECT_TRUE(raster.error().message.starts_with(path)) << raster.error().message;
      EXPECT_EQ(raster.error().message.find('\n'), std::string::npos);
    }
  }
  EXPECT_GT(n_read, 0) << "samples and texts that are others";
}

TEST_F(damaged_netcdf, that_only_begins_like_one_is_refused) {
  for (const std::string& head : {std::string("\x89HDF\r\n\x1a\n"), std::string("CDF\1"),
                                  std::string("CDF\2"), std::string("CDF\5")}) {
    const std::string said = refusal(write(head + " and more"));
    EXPECT_NE(said.find("that is whole"), std::string::npos) << said;
  }
}

TEST_F(damaged_netcdf, of_hdf5_alone_has_no_raster) {
  const std::string path = write_hdf5([](hid_t file) {
    const hsize_t n = 5;
    const hid_t space = H5Screate_simple(1, &n, nullptr);
    H5Dclose(
        H5Dcreate2(file, "list", H5T_NATIVE_INT, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5Sclose(space);
  });
  EXPECT_NE(refusal(path).find("over two dimensions, got none"), std::string::npos)
      << refusal(path);
  const std::string table = write_hdf5([](hid_t file) {
    const hsize_t sides[2] = {3, 4};
    const hid_t space = H5Screate_simple(2, sides, nullptr);
    H5Dclose(
        H5Dcreate2(file, "table", H5T_NATIVE_INT, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5Sclose(space);
  });
  EXPECT_NE(refusal(table).find("got HDF5 whose dimensions have no names, as of table"),
            std::string::npos)
      << refusal(table);
}

TEST_F(damaged_netcdf, is_refused_where_it_names_other_files) {
  std::ofstream((*this)("secret.bin")) << std::string(64, 's');
  write_netcdf_file((*this)("other.nc"), small(NC_NETCDF4));
  const std::string linked = write_hdf5([&](hid_t file) {
    H5Lcreate_external((*this)("other.nc").c_str(), "/z", file, "z", H5P_DEFAULT, H5P_DEFAULT);
  });
  EXPECT_NE(refusal(linked).find("got a link to another file, 'z'"), std::string::npos)
      << refusal(linked);
  const hsize_t sides[2] = {3, 4};
  const std::string stored = write_hdf5([&](hid_t file) {
    const hid_t space = H5Screate_simple(2, sides, nullptr);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_external(creation, (*this)("secret.bin").c_str(), 0, 24);
    H5Dclose(H5Dcreate2(file, "z", H5T_NATIVE_SHORT, space, H5P_DEFAULT, creation, H5P_DEFAULT));
    H5Pclose(creation);
    H5Sclose(space);
  });
  EXPECT_NE(refusal(stored).find("stored in another file"), std::string::npos) << refusal(stored);
  const std::string put_together = write_hdf5([&](hid_t file) {
    const hid_t group = H5Gcreate2(file, "deep", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(2, sides, nullptr);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_virtual(creation, space, (*this)("other.nc").c_str(), "/z", space);
    H5Dclose(H5Dcreate2(group, "z", H5T_NATIVE_SHORT, space, H5P_DEFAULT, creation, H5P_DEFAULT));
    H5Pclose(creation);
    H5Sclose(space);
    H5Gclose(group);
  });
  EXPECT_NE(refusal(put_together).find("put together from other files, 'deep/z'"),
            std::string::npos)
      << refusal(put_together);
}

TEST_F(damaged_netcdf, is_refused_where_it_claims_more_than_it_can_hold) {
  NetcdfFile file{.n_columns = 100000, .n_rows = 100000, .chunk = {1000, 1000}};
  write_netcdf_file((*this)("empty.nc"), file);
  EXPECT_NE(refusal((*this)("empty.nc")).find("that can hold 100000 x 100000 samples"),
            std::string::npos);
  // 2.4 GB of coordinates, none of which the file has.
  file = {.n_columns = 300'000'000, .n_rows = 2, .type = NC_BYTE, .chunk = {1, 1'000'000}};
  file.define = [](int nc, int z) {
    int dimensions[2] = {};
    int x = -1;
    nc_inq_vardimid(nc, z, dimensions);
    const std::size_t chunk = 1'000'000;
    nc_def_var(nc, "lon", NC_DOUBLE, 1, &dimensions[1], &x);
    nc_def_var_chunking(nc, x, NC_CHUNKED, &chunk);
  };
  write_netcdf_file((*this)("empty.nc"), file);
  const std::string said = refusal((*this)("empty.nc"));
  EXPECT_NE(said.find("takes up to 2 GiB of memory"), std::string::npos) << said;
}

TEST_F(damaged_netcdf, that_makes_its_reader_crash_is_an_error) {
  const std::string crashed = failure_of("kill -SEGV $$");
  EXPECT_TRUE(crashed.starts_with((*this)("a.nc"))) << crashed;
  EXPECT_NE(crashed.find("crash of it (Segmentation fault)"), std::string::npos) << crashed;
  EXPECT_NE(failure_of("kill -KILL $$").find("(Killed)"), std::string::npos);
  EXPECT_NE(failure_of("exit 3").find("exit code 3"), std::string::npos);
  EXPECT_NE(failure_of("echo error what it was; exit 1").find("a.nc: what it was"),
            std::string::npos);
}

TEST_F(damaged_netcdf, that_makes_its_reader_hang_is_an_error) {
  const auto begin = std::chrono::steady_clock::now();
  const std::string hung =
      failure_of("echo $$ > " + (*this)("pid") + "; echo progress 0.5; exec sleep 100");
  EXPECT_NE(hung.find("was ended: no word for"), std::string::npos) << hung;
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(30));
  pid_t process = 0;
  std::ifstream((*this)("pid")) >> process;
  ASSERT_GT(process, 0);
  EXPECT_EQ(::kill(process, 0), -1) << "it was ended";
  EXPECT_NE(failure_of("exec cat /dev/zero").find("lines of up to 4 MiB"), std::string::npos);
}

TEST_F(damaged_netcdf, is_given_up_when_cancelled) {
  Progress progress;
  const std::string program = script("exec sleep 100");
  std::jthread canceller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    progress.cancel();
  });
  const auto raster = import_raster((*this)("a.nc"), {}, progress, {.path = program});
  ASSERT_FALSE(raster);
  EXPECT_EQ(raster.error().message, cancelled_error().message);
}

TEST_F(damaged_netcdf, whose_copy_is_none_is_an_error) {
  // Of a reader that ends well and has written nothing: the copy is not read.
  const auto raster = [&] {
    Progress progress;
    return import_raster((*this)("a.nc"), {}, progress, {.path = script("exit 0")});
  }();
  ASSERT_TRUE(raster);
  EXPECT_EQ(std::filesystem::file_size(raster->name()), 0U);
  Progress progress;
  const auto absent = import_raster((*this)("a.nc"), {}, progress, {.path = (*this)("no-program")});
  EXPECT_NE(absent.error().message.find("cannot be started"), std::string::npos);
}

}  // namespace
}  // namespace lode::io
