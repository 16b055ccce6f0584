#include "src/input/generate/generate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "src/base/random.h"
#include "src/input/generate/direction.h"
#include "src/input/generate/halos.h"
#include "src/input/generate/portable_math.h"
#include "src/input/generate/terrain.h"
#include "src/input/generate/writer.h"

namespace tessera {

// Makes the points of one shape in order.
class ShapeSource {
 public:
  virtual ~ShapeSource() = default;
  virtual Point at(std::uint64_t index, std::uint8_t& classification) = 0;
  virtual Bounds bounds() const = 0;
  virtual double step() const { return 0; }
};

namespace {

constexpr std::uint64_t batch_points = 65'536;
constexpr std::array<std::pair<std::string_view, CloudShape>, 6> shapes{{{"uniform", CloudShape::uniform},
                                                                         {"normal", CloudShape::normal},
                                                                         {"sphere", CloudShape::sphere},
                                                                         {"grid", CloudShape::grid},
                                                                         {"terrain", CloudShape::terrain},
                                                                         {"halos", CloudShape::halos}}};

// A cube, or in 2D a square, from lo to hi.
Bounds cube(double lo, double hi, int dimension) {
  Bounds bounds;
  bounds.add(Point{lo, lo, dimension == 2 ? 0 : lo});
  bounds.add(Point{hi, hi, dimension == 2 ? 0 : hi});
  return bounds;
}

class UniformSource : public ShapeSource {
 public:
  explicit UniformSource(const GenerateOptions& options) : random_(options.seed), dimension_(options.dimension) {}
  Point at(std::uint64_t, std::uint8_t&) override {
    Point p;
    for (int axis = 0; axis < dimension_; ++axis) p[axis] = random_.unit();
    return p;
  }
  Bounds bounds() const override { return cube(0, 1, dimension_); }

 private:
  Random random_;
  int dimension_;
};

// The polar method of Marsaglia makes two normal numbers at a time.
class NormalSource : public ShapeSource {
 public:
  explicit NormalSource(const GenerateOptions& options) : random_(options.seed), dimension_(options.dimension) {}
  Point at(std::uint64_t, std::uint8_t&) override {
    Point p;
    for (int axis = 0; axis < dimension_; ++axis) p[axis] = draw();
    return p;
  }
  // In draw() s >= 2^-104, so |v| <= sqrt(-2 log s) < 12.1.
  Bounds bounds() const override { return cube(-12.1, 12.1, dimension_); }

 private:
  double draw() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    double u = 0, v = 0, s = 0;
    do {
      u = random_.between(-1, 1);
      v = random_.between(-1, 1);
      s = u * u + v * v;
    } while (s >= 1 || s == 0);
    const double factor = std::sqrt(-2 * portable_log(s) / s);
    spare_ = v * factor;
    has_spare_ = true;
    return u * factor;
  }

  Random random_;
  int dimension_;
  bool has_spare_ = false;
  double spare_ = 0;
};

class SphereSource : public ShapeSource {
 public:
  explicit SphereSource(const GenerateOptions& options) : random_(options.seed), dimension_(options.dimension) {}
  Point at(std::uint64_t, std::uint8_t&) override { return direction(random_, dimension_); }
  Bounds bounds() const override { return cube(-1 - 1e-9, 1 + 1e-9, dimension_); }

 private:
  Random random_;
  int dimension_;
};

class GridSource : public ShapeSource {
 public:
  explicit GridSource(const GenerateOptions& options) : dimension_(options.dimension) {
    const auto holds = [&](std::uint64_t side) {
      long double volume = 1;
      for (int i = 0; i < dimension_; ++i) volume *= static_cast<long double>(side);
      return volume >= static_cast<long double>(options.points);
    };
    // pow() may be off in either direction.
    const double root = std::pow(static_cast<double>(options.points), 1.0 / dimension_);
    side_ = static_cast<std::uint64_t>(std::max(1.0, root - 2));
    while (!holds(side_)) ++side_;
  }
  Point at(std::uint64_t index, std::uint8_t&) override {
    Point p;
    for (int axis = 0; axis < dimension_; ++axis, index /= side_) p[axis] = static_cast<double>(index % side_);
    return p;
  }
  Bounds bounds() const override { return cube(0, static_cast<double>(side_ - 1), dimension_); }
  double step() const override { return 1; }

 private:
  int dimension_;
  std::uint64_t side_ = 1;
};

class TerrainSource : public ShapeSource {
 public:
  explicit TerrainSource(const GenerateOptions& options)
      : terrain_(options.points, options.seed), dimension_(options.dimension) {}
  Point at(std::uint64_t index, std::uint8_t& classification) override {
    auto found = terrain_.at(index);
    classification = found.classification;
    if (dimension_ == 2) found.at.z = 0;
    return found.at;
  }
  Bounds bounds() const override { return terrain_.bounds(); }
  double step() const override { return Terrain::step(); }

 private:
  Terrain terrain_;
  int dimension_;
};

class HaloSource : public ShapeSource {
 public:
  explicit HaloSource(const GenerateOptions& options)
      : halos_(options.points, options.seed, options.dimension), dimension_(options.dimension) {}
  Point at(std::uint64_t, std::uint8_t&) override { return halos_.next(); }
  Bounds bounds() const override { return cube(0, 1, dimension_); }

 private:
  Halos halos_;
  int dimension_;
};

std::unique_ptr<ShapeSource> make_source(const GenerateOptions& options) {
  switch (options.shape) {
    case CloudShape::uniform:
      return std::make_unique<UniformSource>(options);
    case CloudShape::normal:
      return std::make_unique<NormalSource>(options);
    case CloudShape::sphere:
      return std::make_unique<SphereSource>(options);
    case CloudShape::grid:
      return std::make_unique<GridSource>(options);
    case CloudShape::halos:
      return std::make_unique<HaloSource>(options);
    case CloudShape::terrain:
      break;
  }
  return std::make_unique<TerrainSource>(options);
}

}  // namespace

std::optional<CloudShape> shape_named(std::string_view name) {
  for (const auto& [known, shape] : shapes)
    if (known == name) return shape;
  return std::nullopt;
}

PointGenerator::PointGenerator(const GenerateOptions& options) : options_(options), source_(make_source(options)) {}
PointGenerator::~PointGenerator() = default;

void PointGenerator::next(std::vector<Point>& points, std::vector<std::uint8_t>& classes) {
  const auto n = static_cast<std::size_t>(std::min(batch_points, options_.points - done_));
  points.resize(n);
  classes.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) points[i] = source_->at(done_++, classes[i]);
}

Bounds PointGenerator::bounds() const { return source_->bounds(); }
double PointGenerator::step() const { return source_->step(); }

Status generate(const GenerateOptions& options, const std::filesystem::path& path,
                const std::function<bool(std::uint64_t)>& keep_going) {
  if (options.points == 0) return error(Errc::usage, "a cloud of 0 points cannot be generated");
  if (options.dimension != 2 && options.dimension != 3) return error(Errc::usage, "the dimension must be 2 or 3");
  PointGenerator generator(options);
  BOOST_OUTCOME_TRY(writer, open_writer(path, {.dimension = options.dimension,
                                               .points = options.points,
                                               .bounds = generator.bounds(),
                                               .step = generator.step()}));
  std::vector<Point> points;
  std::vector<std::uint8_t> classes;
  std::uint64_t written = 0;
  while (true) {
    generator.next(points, classes);
    if (points.empty()) break;
    BOOST_OUTCOME_TRYV(writer->write(points, classes));
    written += points.size();
    if (keep_going && !keep_going(written))
      return error(Errc::interrupted, path.string() + ": interrupted; nothing was left there");
  }
  return writer->finish();
}

}  // namespace tessera
