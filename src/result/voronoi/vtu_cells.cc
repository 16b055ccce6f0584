#include "src/result/voronoi/vtu_cells.h"

#include <algorithm>
#include <cerrno>
#include <compare>
#include <set>
#include <span>
#include <utility>

#include "src/result/export/ending.h"
#include "src/result/voronoi/cell_fields.h"
#include "src/result/voronoi/polyhedron.h"

namespace tessera::voronoi {

namespace fs = std::filesystem;

namespace {

// A corner of a cell; corners are numbered through all cells.
struct PlacedCorner {
  Point at;
  std::uint64_t slot = 0;
  friend bool operator<(const PlacedCorner& a, const PlacedCorner& b) {
    for (int axis = 0; axis < 3; ++axis)
      if (a.at[axis] != b.at[axis]) return a.at[axis] < b.at[axis];
    return a.slot < b.slot;
  }
};
struct NumberedCorner {
  std::uint64_t slot = 0, number = 0;
  friend bool operator<(const NumberedCorner& a, const NumberedCorner& b) { return a.slot < b.slot; }
};

// An array of the file, kept in scratch until its size is known.
struct ScratchArray {
  std::string name, type;
  int components = 1;
  FileHandle file = {};
  std::unique_ptr<exports::Stream> stream = {};
};

const char* vtk_type_of(AttributeType type) {
  constexpr const char* names[] = {"UInt8", "Int8",   "UInt16", "Int16",   "UInt32",
                                   "Int32", "UInt64", "Int64",  "Float32", "Float64"};
  return names[static_cast<int>(type)];
}

class VtuCells : public CellFile {
 public:
  static Result<std::unique_ptr<CellFile>> create(const fs::path& target, const VtuCellsOptions& options) {
    BOOST_OUTCOME_TRY(file, exports::OutputFile::create(target));
    auto cells = std::unique_ptr<VtuCells>(new VtuCells(std::move(file), target, options));
    BOOST_OUTCOME_TRYV(cells->make_arrays());
    return std::unique_ptr<CellFile>(std::move(cells));
  }

  Status add(const CellRecord& record) override {
    const Polyhedron cell = unpacked(record.shape);
    for (const Point& p : cell.corners) {
      BOOST_OUTCOME_TRYV(corners_.push({p, slots_++}));
    }
    put(layout, std::int64_t(cell.corners.size()));
    put(layout, std::int64_t(cell.faces.size()));
    std::int64_t numbers = 1;
    for (const auto& face : cell.faces) {
      put(layout, std::int64_t(face.size()));
      for (const std::uint32_t corner : face) put(layout, std::int64_t{corner});
      numbers += 1 + std::int64_t(face.size());
    }
    ends_ += std::int64_t(cell.corners.size());
    face_ends_ += numbers;
    put(offsets, ends_);
    put(face_offsets, face_ends_);
    put(types, std::uint8_t{42});  // VTK_POLYHEDRON
    put(first_column, record.head.id);
    put(first_column + 1, record.head.size);
    put(first_column + 2, record.head.surface);
    put(first_column + 3, record.head.neighbours);
    put(first_column + 4, static_cast<std::uint8_t>(record.head.unbounded));
    put(first_column + 5, record.head.centroid);
    const std::byte* at = record.row.data();
    for (std::size_t i = 0; i < options_.schema.size(); ++i) {
      const std::size_t size = size_of(options_.schema[i].type);
      arrays_[first_column + 6 + i].stream->bytes({at, size});
      at += size;
    }
    ++cells_;
    return success();
  }

  Result<std::uint64_t> finish() override {
    BOOST_OUTCOME_TRYV(number_corners());
    for (ScratchArray& array : arrays_) {
      BOOST_OUTCOME_TRYV(array.stream->flush());
    }
    exports::Stream out(file_, 0);
    out.text(head());
    for (std::size_t i = 0; i < arrays_.size(); ++i) {
      if (i == layout) continue;
      BOOST_OUTCOME_TRYV(copy(arrays_[i], out));
    }
    out.text("\n</AppendedData>\n</VTKFile>\n");
    BOOST_OUTCOME_TRYV(out.flush());
    return file_.finish();
  }

 private:
  enum Array : std::size_t { points, connectivity, offsets, types, faces, face_offsets, layout, first_column };

  VtuCells(exports::OutputFile file, const fs::path& target, const VtuCellsOptions& options)
      : file_(std::move(file)),
        scratch_(exports::folder_of(target)),
        options_(options),
        corners_(scratch_, options.memory_bytes / 2, options.stop),
        numbers_(scratch_, options.memory_bytes / 2, options.stop) {}

  Status make_arrays() {
    const auto add = [&](std::string name, std::string type, int components = 1) -> Status {
      BOOST_OUTCOME_TRY(file, nameless_file(scratch_));
      const int fd = file.get();
      arrays_.push_back({std::move(name), std::move(type), components, std::move(file),
                         std::make_unique<exports::Stream>(fd, file_.target(), 0)});
      return success();
    };
    BOOST_OUTCOME_TRYV(add("Points", "Float64", 3));
    for (const char* name : {"connectivity", "offsets"}) {
      BOOST_OUTCOME_TRYV(add(name, "Int64"));
    }
    BOOST_OUTCOME_TRYV(add("types", "UInt8"));
    for (const char* name : {"faces", "faceoffsets", "layout"}) {
      BOOST_OUTCOME_TRYV(add(name, "Int64"));
    }
    BOOST_OUTCOME_TRYV(add("id", "UInt64"));
    BOOST_OUTCOME_TRYV(add("volume", "Float64"));
    BOOST_OUTCOME_TRYV(add("surface", "Float64"));
    BOOST_OUTCOME_TRYV(add("neighbours", "UInt32"));
    BOOST_OUTCOME_TRYV(add("unbounded", "UInt8"));
    BOOST_OUTCOME_TRYV(add("centroid", "Float64", 3));
    std::set<std::string> taken{"id", "volume", "surface", "neighbours", "unbounded", "centroid"};
    for (const Attribute& attribute : options_.schema) {
      BOOST_OUTCOME_TRYV(add(exports::field_name(attribute.name, taken), vtk_type_of(attribute.type)));
    }
    return success();
  }

  template <class Value>
  void put(std::size_t array, const Value& value) {
    arrays_[array].stream->value(value);
  }

  // Numbers the corners by their coordinates, and writes all that has their numbers.
  Status number_corners() {
    std::uint64_t number = 0;
    Point last{};
    BOOST_OUTCOME_TRYV(corners_.for_each([&](const PlacedCorner& corner) -> Status {
      if (number == 0 || corner.at != last) {
        put(points, corner.at);
        last = corner.at;
        ++number;
      }
      return numbers_.push({corner.slot, number - 1});
    }));
    points_ = number;
    BOOST_OUTCOME_TRYV(arrays_[layout].stream->flush());
    std::vector<std::int64_t> cell;  // the numbers of a cell's corners
    std::uint64_t wanted = 0;
    LayoutReader reader(arrays_[layout].file.get());
    return numbers_.for_each([&](const NumberedCorner& corner) -> Status {
      if (cell.empty()) {
        BOOST_OUTCOME_TRY(count, reader.next());
        wanted = static_cast<std::uint64_t>(count);
      }
      put(connectivity, static_cast<std::int64_t>(corner.number));
      cell.push_back(static_cast<std::int64_t>(corner.number));
      if (cell.size() < wanted) return success();
      BOOST_OUTCOME_TRYV(write_faces(reader, cell));
      cell.clear();
      return success();
    });
  }

  // Reads numbers that were written one after the other.
  class LayoutReader {
   public:
    explicit LayoutReader(int fd) : fd_(fd) {}
    Result<std::int64_t> next() {
      if (at_ == buffer_.size()) {
        buffer_.resize(std::size_t{1} << 15);
        BOOST_OUTCOME_TRY(read, read_up_to(fd_, std::as_writable_bytes(std::span(buffer_)), done_, "the scratch file"));
        if (read < sizeof(std::int64_t)) return io_error("the scratch file", "cannot read back", EIO);
        buffer_.resize(read / sizeof(std::int64_t));
        done_ += read;
        at_ = 0;
      }
      return buffer_[at_++];
    }

   private:
    int fd_;
    std::vector<std::int64_t> buffer_;
    std::size_t at_ = 0;
    std::uint64_t done_ = 0;
  };

  Status write_faces(LayoutReader& reader, std::span<const std::int64_t> cell) {
    BOOST_OUTCOME_TRY(count, reader.next());
    put(faces, count);
    for (std::int64_t f = 0; f < count; ++f) {
      BOOST_OUTCOME_TRY(corners, reader.next());
      put(faces, corners);
      for (std::int64_t i = 0; i < corners; ++i) {
        BOOST_OUTCOME_TRY(corner, reader.next());
        put(faces, cell[static_cast<std::size_t>(corner)]);
      }
    }
    return success();
  }

  std::string head() const {
    std::uint64_t offset = 0;
    std::vector<std::string> declared(arrays_.size());
    for (std::size_t i = 0; i < arrays_.size(); ++i) {
      if (i == layout) continue;
      const ScratchArray& array = arrays_[i];
      declared[i] = "<DataArray type=\"" + array.type + "\" Name=\"" + exports::xml_text(array.name) +
                    "\" NumberOfComponents=\"" + std::to_string(array.components) + "\" format=\"appended\" offset=\"" +
                    std::to_string(offset) + "\"/>\n";
      offset += 8 + array.stream->offset();
    }
    std::string text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<!-- " +
        comment_of(options_.stamp) + " -->\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"" + std::to_string(points_) +
        "\" NumberOfCells=\"" + std::to_string(cells_) + "\">\n<Points>\n" + declared[points] + "</Points>\n<Cells>\n";
    for (std::size_t i = connectivity; i < layout; ++i) text += declared[i];
    text += "</Cells>\n<CellData>\n";
    for (std::size_t i = first_column; i < declared.size(); ++i) text += declared[i];
    return text + "</CellData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
  }

  Status copy(const ScratchArray& array, exports::Stream& out) {
    const std::uint64_t size = array.stream->offset();
    out.value(size);
    std::vector<std::byte> bytes(std::size_t{1} << 18);
    for (std::uint64_t at = 0; at < size;) {
      if (options_.stop.stop_requested()) return error(Errc::interrupted, "interrupted while writing cells");
      const auto part = std::span(bytes).first(std::min<std::uint64_t>(bytes.size(), size - at));
      BOOST_OUTCOME_TRY(read, read_up_to(array.file.get(), part, at, "the scratch file"));
      if (read != part.size()) return io_error("the scratch file", "cannot read back", EIO);
      out.bytes(part);
      at += read;
    }
    return out.status();
  }

  exports::OutputFile file_;
  fs::path scratch_;
  VtuCellsOptions options_;
  std::vector<ScratchArray> arrays_;
  ExternalSort<PlacedCorner> corners_;
  ExternalSort<NumberedCorner> numbers_;
  std::uint64_t slots_ = 0, cells_ = 0, points_ = 0;
  std::int64_t ends_ = 0, face_ends_ = 0;
};

}  // namespace

Status check_vtu_ending(const fs::path& target) {
  if (exports::ending_of(target) == ".vtu") return success();
  return error(Errc::usage,
               target.string() + ": cells of a 3D result are written for VTK, so give a name that ends in .vtu");
}

Result<std::unique_ptr<CellFile>> create_vtu_cells(const fs::path& target, const VtuCellsOptions& options) {
  return VtuCells::create(target, options);
}

}  // namespace tessera::voronoi
