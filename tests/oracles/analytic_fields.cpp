#include "tests/oracles/analytic_fields.h"

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "tests/oracles/gaussians40.h"
#include "tests/oracles/typed_samples.h"

namespace lode::oracles {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMarschnerLobbAmplitude = 0.25;
constexpr double kMarschnerLobbFrequency = 6;
constexpr double kGyroidWaveNumber = 8 * kPi;

// A Gaussian is a product over the axes. value() and sample() multiply the same three factors in
// the same order, so both give the same bits.
double gaussian_factor(double distance, double sigma) {
  return std::exp(-(distance * distance) / (2 * sigma * sigma));
}

double gaussians40_value(const Vec3d& p) {
  double sum = 0;
  for (const auto& [c, sigma] : kGaussians40) {
    const double zy = gaussian_factor(p[2] - c[2], sigma) * gaussian_factor(p[1] - c[1], sigma);
    sum += zy * gaussian_factor(p[0] - c[0], sigma);
  }
  return sum;
}

Vec3d gaussians40_gradient(const Vec3d& p) {
  Vec3d sum;
  for (const auto& [c, sigma] : kGaussians40) {
    const Vec3d d = p - c;
    const double g = std::exp(-dot(d, d) / (2 * sigma * sigma));
    sum = sum + d * (-g / (sigma * sigma));
  }
  return sum;
}

double marschner_lobb_ring(double r) {
  return std::cos(2 * kPi * kMarschnerLobbFrequency * std::cos(kPi * r / 2));
}

double marschner_lobb_value(const Vec3d& p) {
  const double a = kMarschnerLobbAmplitude;
  const double r = std::sqrt(p[0] * p[0] + p[1] * p[1]);
  return (1 - std::sin(kPi * p[2] / 2) + a * (1 + marschner_lobb_ring(r))) / (2 * (1 + a));
}

Vec3d marschner_lobb_gradient(const Vec3d& p) {
  const double a = kMarschnerLobbAmplitude;
  const double f = kMarschnerLobbFrequency;
  const double r = std::sqrt(p[0] * p[0] + p[1] * p[1]);
  const double by_r = a * std::sin(2 * kPi * f * std::cos(kPi * r / 2)) * 2 * kPi * f *
                      std::sin(kPi * r / 2) * kPi / 2;
  const double radial = r > 0 ? by_r / r : 0;
  const Vec3d sum{{radial * p[0], radial * p[1], -kPi / 2 * std::cos(kPi * p[2] / 2)}};
  return sum * (1 / (2 * (1 + a)));
}

struct SineCosine {
  double sine;
  double cosine;
};

SineCosine gyroid_wave(double coordinate) {
  const double angle = kGyroidWaveNumber * coordinate;
  return {std::sin(angle), std::cos(angle)};
}

double gyroid_value(const SineCosine& x, const SineCosine& y, const SineCosine& z) {
  return x.sine * y.cosine + y.sine * z.cosine + z.sine * x.cosine;
}

Vec3d gyroid_gradient(const Vec3d& p) {
  const SineCosine x = gyroid_wave(p[0]), y = gyroid_wave(p[1]), z = gyroid_wave(p[2]);
  return kGyroidWaveNumber *
         Vec3d{{x.cosine * y.cosine - z.sine * x.sine, y.cosine * z.cosine - x.sine * y.sine,
                z.cosine * x.cosine - y.sine * z.sine}};
}

std::vector<double> axis_coordinates(std::int32_t n) {
  std::vector<double> coordinates(static_cast<std::size_t>(n), 0.0);
  if (n > 1)
    for (std::int32_t i = 0; i < n; ++i)
      coordinates[static_cast<std::size_t>(i)] = -1.0 + 2.0 * i / (n - 1);
  return coordinates;
}

// What depends on x alone, once for all rows: exponentials are nearly all of the cost.
struct RowTables {
  std::vector<double> x;
  std::vector<std::vector<double>> gaussian_x;  // per blob, per x
  std::vector<SineCosine> wave_x;
};

RowTables make_row_tables(Field field, std::int32_t n) {
  RowTables tables{axis_coordinates(n), {}, {}};
  if (field == Field::gaussians40)
    for (const auto& [c, sigma] : kGaussians40) {
      auto& factors = tables.gaussian_x.emplace_back();
      for (const double x : tables.x) factors.push_back(gaussian_factor(x - c[0], sigma));
    }
  if (field == Field::gyroid)
    for (const double x : tables.x) tables.wave_x.push_back(gyroid_wave(x));
  return tables;
}

void fill_gaussians40_row(const RowTables& tables, double y, double z, std::span<double> row) {
  std::fill(row.begin(), row.end(), 0.0);
  for (std::size_t g = 0; g < kGaussians40.size(); ++g) {
    const auto& [c, sigma] = kGaussians40[g];
    const double zy = gaussian_factor(z - c[2], sigma) * gaussian_factor(y - c[1], sigma);
    const double* factors = tables.gaussian_x[g].data();
    for (std::size_t i = 0; i < row.size(); ++i) row[i] += zy * factors[i];
  }
}

void fill_row(Field field, const RowTables& tables, double y, double z, std::span<double> row) {
  if (field == Field::gaussians40) return fill_gaussians40_row(tables, y, z, row);
  if (field == Field::gyroid) {
    const SineCosine wave_y = gyroid_wave(y), wave_z = gyroid_wave(z);
    for (std::size_t i = 0; i < row.size(); ++i)
      row[i] = gyroid_value(tables.wave_x[i], wave_y, wave_z);
    return;
  }
  for (std::size_t i = 0; i < row.size(); ++i) row[i] = value(field, {{tables.x[i], y, z}});
}

}  // namespace

std::string_view name_of(Field field) {
  constexpr std::array<std::string_view, 4> kNames = {"gaussians40", "sphere", "marschner_lobb",
                                                      "gyroid"};
  return kNames[static_cast<std::size_t>(field)];
}

double usual_isovalue(Field field) {
  constexpr std::array kIsovalues = {1.0, 0.7, 0.5, 0.0};
  return kIsovalues[static_cast<std::size_t>(field)];
}

double value(Field field, const Vec3d& point) {
  switch (field) {
    case Field::gaussians40: return gaussians40_value(point);
    case Field::sphere: return length(point);
    case Field::marschner_lobb: return marschner_lobb_value(point);
    case Field::gyroid: break;
  }
  return gyroid_value(gyroid_wave(point[0]), gyroid_wave(point[1]), gyroid_wave(point[2]));
}

Vec3d gradient(Field field, const Vec3d& point) {
  switch (field) {
    case Field::gaussians40: return gaussians40_gradient(point);
    case Field::sphere: return normalized(point);
    case Field::marschner_lobb: return marschner_lobb_gradient(point);
    case Field::gyroid: break;
  }
  return gyroid_gradient(point);
}

RegularGrid field_grid(const Index3& dims) {
  RegularGrid grid{.dims = dims};
  for (std::size_t i = 0; i < 3; ++i) {
    grid.spacing[i] = dims[i] > 1 ? 2.0 / (dims[i] - 1) : 1.0;
    grid.origin[i] = dims[i] > 1 ? -1.0 : 0.0;
  }
  return grid;
}

Volume sample(Field field, const Index3& dims, const SampleOptions& options) {
  const RowTables tables = make_row_tables(field, dims[0]);
  const std::vector<double> ys = axis_coordinates(dims[1]), zs = axis_coordinates(dims[2]);
  Volume volume = empty_volume(field_grid(dims), options.type);
  volume.info.field_name = name_of(field);
  const std::size_t n_x = tables.x.size();
  visit_scalar_type(options.type, [&]<typename T>() {
    const std::span<T> samples = typed_samples<T>(volume);
    parallel_for(zs.size(), Threads{}, 1, [&](std::size_t z, int) {
      std::vector<double> row(n_x);
      for (std::size_t y = 0; y < ys.size(); ++y) {
        fill_row(field, tables, ys[y], zs[z], row);
        T* out = samples.data() + (z * ys.size() + y) * n_x;
        for (std::size_t x = 0; x < n_x; ++x)
          out[x] = to_sample<T>(options.scale * row[x] + options.offset);
      }
    });
  });
  return volume;
}

Volume sample(Field field, std::int32_t n, const SampleOptions& options) {
  return sample(field, Index3{{n, n, n}}, options);
}

}  // namespace lode::oracles
