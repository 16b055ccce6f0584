#include "src/input/generate/writer.h"

#include <cassert>
#include <charconv>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/output_file.h"
#include "src/input/generate/las_writer.h"

namespace tessera {
namespace {

// Writes doubles x y (z), point after point, behind a header: PLY and NumPy.
class BinaryWriter : public PointWriter {
 public:
  BinaryWriter(OutputFile file, const WriterOptions& options) : file_(std::move(file)), options_(options) {}

  Status begin(const std::string& header) { return file_.append(header); }
  Status write(std::span<const Point> points, std::span<const std::uint8_t>) override {
    written_ += points.size();
    if (options_.dimension == 3) return file_.append(std::as_bytes(points));
    pairs_.clear();
    for (const auto& p : points) {
      pairs_.push_back(p.x);
      pairs_.push_back(p.y);
    }
    return file_.append(std::as_bytes(std::span<const double>(pairs_)));
  }
  Status finish() override {
    assert(written_ == options_.points && "the header has promised another number of points");
    return file_.commit();
  }

 private:
  OutputFile file_;
  WriterOptions options_;
  std::uint64_t written_ = 0;
  std::vector<double> pairs_;
};

class TextWriter : public PointWriter {
 public:
  TextWriter(OutputFile file, int dimension, char delimiter)
      : file_(std::move(file)), dimension_(dimension), delimiter_(delimiter) {}

  Status begin() {
    if (delimiter_ != ',') return success();
    return file_.append(dimension_ == 2 ? std::string_view("x,y\n") : std::string_view("x,y,z\n"));
  }
  Status write(std::span<const Point> points, std::span<const std::uint8_t>) override {
    for (const auto& p : points) {
      char line[128];  // 3 numbers of at most 24 characters
      char* at = line;
      for (int axis = 0; axis < dimension_; ++axis) {
        at = std::to_chars(at, line + sizeof line, p[axis]).ptr;
        *at++ = axis + 1 == dimension_ ? '\n' : delimiter_;
      }
      BOOST_OUTCOME_TRYV(file_.append(std::string_view(line, static_cast<std::size_t>(at - line))));
    }
    return success();
  }
  Status finish() override { return file_.commit(); }

 private:
  OutputFile file_;
  int dimension_;
  char delimiter_;
};

std::string ply_header(const WriterOptions& options) {
  return "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(options.points) +
         "\nproperty double x\nproperty double y\n" + (options.dimension == 3 ? "property double z\n" : "") +
         "end_header\n";
}

std::string npy_header(const WriterOptions& options) {
  std::string literal = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(options.points) + ", " +
                        std::to_string(options.dimension) + "), }";
  literal.resize(117, ' ');  // 10 + 118 bytes, so that the data begins at a multiple of 64
  literal += '\n';
  return std::string("\x93NUMPY\x01\x00\x76\x00", 10) + literal;
}

}  // namespace

Result<std::unique_ptr<PointWriter>> open_writer(const std::filesystem::path& path, const WriterOptions& options) {
  const std::string extension = path.extension().string();
  const bool binary = extension == ".ply" || extension == ".npy";
  const bool text = extension == ".xyz" || extension == ".txt" || extension == ".csv";
  if (!binary && !text && extension != ".las")
    return error(Errc::usage, path.string() + ": points are written as .las, .ply, .npy, .xyz, .txt or .csv");
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  if (extension == ".las") return open_las_writer(std::move(file), options);
  if (binary) {
    auto writer = std::make_unique<BinaryWriter>(std::move(file), options);
    BOOST_OUTCOME_TRYV(writer->begin(extension == ".ply" ? ply_header(options) : npy_header(options)));
    return std::unique_ptr<PointWriter>(std::move(writer));
  }
  auto writer = std::make_unique<TextWriter>(std::move(file), options.dimension, extension == ".csv" ? ',' : ' ');
  BOOST_OUTCOME_TRYV(writer->begin());
  return std::unique_ptr<PointWriter>(std::move(writer));
}

}  // namespace tessera
