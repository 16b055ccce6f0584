#include "src/base/hdf5/hdf5_output.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/base/hdf5/hdf5_library.h"
#include "src/base/printable.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// The bytes that HDF5 writes, by their place in the file: HDF5 leaves out the numbers of tables.
class Hdf5Pages {
 public:
  static constexpr std::size_t page_bytes = 4096;
  using Page = std::array<std::byte, page_bytes>;

  void write(std::uint64_t at, std::span<const std::byte> bytes) {
    each_piece(at, bytes.size(), [&](std::uint64_t page, std::size_t in_page, std::size_t from, std::size_t size) {
      std::memcpy(pages_[page].data() + in_page, bytes.data() + from, size);
    });
  }
  void read(std::uint64_t at, std::span<std::byte> bytes) const {
    each_piece(at, bytes.size(), [&](std::uint64_t page, std::size_t in_page, std::size_t from, std::size_t size) {
      const auto found = pages_.find(page);
      if (found == pages_.end())
        std::memset(bytes.data() + from, 0, size);
      else
        std::memcpy(bytes.data() + from, found->second.data() + in_page, size);
    });
  }
  const std::map<std::uint64_t, Page>& pages() const { return pages_; }

 private:
  template <class Use>
  static void each_piece(std::uint64_t at, std::size_t size, const Use& use) {
    for (std::size_t from = 0; from < size;) {
      const auto in_page = static_cast<std::size_t>((at + from) % page_bytes);
      const std::size_t piece = std::min(size - from, page_bytes - in_page);
      use((at + from) / page_bytes, in_page, from, piece);
      from += piece;
    }
  }
  std::map<std::uint64_t, Page> pages_;
};

// The driver that HDF5 writes through. The file has the size `end` in the end.
struct Hdf5Sink {
  Hdf5Pages pages;
  haddr_t end = 0;
};
struct SinkFile {
  H5FD_t common;  // first: HDF5 sees this part alone
  Hdf5Sink* sink;
};
struct SinkInfo {
  Hdf5Sink* sink;
};

Hdf5Sink& sink_of(const H5FD_t* file) { return *reinterpret_cast<const SinkFile*>(file)->sink; }

H5FD_t* open_sink(const char*, unsigned, hid_t access, haddr_t) {
  const auto library = hdf5_library();
  const auto* info = static_cast<const SinkInfo*>(library.value()->H5Pget_driver_info(access));
  if (info == nullptr) return nullptr;
  *info->sink = {};
  auto* file = new SinkFile{};
  file->sink = info->sink;
  return &file->common;
}
herr_t close_sink(H5FD_t* file) {
  delete reinterpret_cast<SinkFile*>(file);
  return 0;
}
int compare_sinks(const H5FD_t* a, const H5FD_t* b) {
  return &sink_of(a) < &sink_of(b) ? -1 : &sink_of(b) < &sink_of(a);
}
herr_t query_sink(const H5FD_t*, unsigned long* flags) {
  *flags = 0;
  return 0;
}
haddr_t sink_end(const H5FD_t* file, H5FD_mem_t) { return sink_of(file).end; }
herr_t set_sink_end(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  sink_of(file).end = end;
  return 0;
}
herr_t read_sink(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, void* buffer) {
  sink_of(file).pages.read(at, std::span(static_cast<std::byte*>(buffer), size));
  return 0;
}
herr_t write_sink(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, const void* buffer) {
  sink_of(file).pages.write(at, std::span(static_cast<const std::byte*>(buffer), size));
  return 0;
}

hid_t sink_driver(const Hdf5Library& hdf5) {
  static const H5FD_class_t driver = [] {
    H5FD_class_t made{};
    made.name = "tessera_sink";
    made.maxaddr = static_cast<haddr_t>(INT64_MAX);
    made.fc_degree = H5F_CLOSE_STRONG;
    made.fapl_size = sizeof(SinkInfo);
    made.open = open_sink;
    made.close = close_sink;
    made.cmp = compare_sinks;
    made.query = query_sink;
    made.get_eoa = sink_end;
    made.set_eoa = set_sink_end;
    made.get_eof = sink_end;
    made.read = read_sink;
    made.write = write_sink;
    return made;
  }();
  static const hid_t id = hdf5.H5FDregister(&driver);
  return id;
}

bool add_attribute(const Hdf5Library& hdf5, hid_t to, const Hdf5Attribute& attribute) {
  const auto add = [&](const Hdf5Handle& space, hid_t type, const void* data) {
    const Hdf5Handle made(hdf5.H5Acreate2(to, attribute.name.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                          hdf5.H5Aclose);
    return made && hdf5.H5Awrite(made.get(), type, data) >= 0;
  };
  if (const auto* text = std::get_if<std::string>(&attribute.value)) {
    const Hdf5Handle type(hdf5.H5Tcopy(hdf5.H5T_C_S1_g), hdf5.H5Tclose);
    const char* const begin = text->c_str();
    return type && hdf5.H5Tset_size(type.get(), H5T_VARIABLE) >= 0 &&
           hdf5.H5Tset_cset(type.get(), H5T_CSET_UTF8) >= 0 &&
           add({hdf5.H5Screate(H5S_SCALAR), hdf5.H5Sclose}, type.get(), static_cast<const void*>(&begin));
  }
  const auto add_numbers = [&](const auto& numbers, hid_t type) {
    const hsize_t size = numbers.size();
    const hid_t space = size == 1 ? hdf5.H5Screate(H5S_SCALAR) : hdf5.H5Screate_simple(1, &size, nullptr);
    return add({space, hdf5.H5Sclose}, type, numbers.data());
  };
  if (const auto* numbers = std::get_if<std::vector<double>>(&attribute.value))
    return add_numbers(*numbers, hdf5.H5T_NATIVE_DOUBLE_g);
  return add_numbers(std::get<std::vector<std::int64_t>>(attribute.value), hdf5.H5T_NATIVE_INT64_g);
}

bool add_group(const Hdf5Library& hdf5, hid_t file, const Hdf5Group& group) {
  const Hdf5Handle made(hdf5.H5Gcreate2(file, group.name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                        hdf5.H5Gclose);
  return made && std::all_of(group.attributes.begin(), group.attributes.end(),
                             [&](const auto& attribute) { return add_attribute(hdf5, made.get(), attribute); });
}

// Returns where the numbers of the table begin, or HADDR_UNDEF.
haddr_t add_table(const Hdf5Library& hdf5, hid_t file, const Hdf5Table& table) {
  const std::vector<hsize_t> shape(table.shape.begin(), table.shape.end());
  const Hdf5Handle links(hdf5.H5Pcreate(hdf5.H5P_CLS_LINK_CREATE_ID_g), hdf5.H5Pclose),
      properties(hdf5.H5Pcreate(hdf5.H5P_CLS_DATASET_CREATE_ID_g), hdf5.H5Pclose),
      space(hdf5.H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), hdf5.H5Sclose);
  if (!links || !properties || !space || hdf5.H5Pset_create_intermediate_group(links.get(), 1) < 0 ||
      hdf5.H5Pset_alloc_time(properties.get(), H5D_ALLOC_TIME_EARLY) < 0 ||
      hdf5.H5Pset_fill_time(properties.get(), H5D_FILL_TIME_NEVER) < 0 ||
      hdf5.H5Pset_obj_track_times(properties.get(), false) < 0)
    return HADDR_UNDEF;
  const Hdf5Handle made(hdf5.H5Dcreate2(file, table.name.c_str(), hdf5_memory_type(hdf5, table.type), space.get(),
                                        links.get(), properties.get(), H5P_DEFAULT),
                        hdf5.H5Dclose);
  if (!made) return HADDR_UNDEF;
  for (const auto& attribute : table.attributes)
    if (!add_attribute(hdf5, made.get(), attribute)) return HADDR_UNDEF;
  return hdf5.H5Dget_offset(made.get());
}

// Lets HDF5 describe the file. Returns where the numbers of each table begin.
Result<std::vector<haddr_t>> describe(const fs::path& target, const Hdf5Layout& layout, Hdf5Sink& sink) {
  const auto library = hdf5_library();
  if (!library) return error(library.error().code, target.string() + ": " + library.error().where);
  const std::lock_guard lock(hdf5_mutex());
  const Hdf5Library& hdf5 = *library.value();
  const auto refused = [&](const std::string& what) {
    return error(Errc::usage, target.string() + ": HDF5 takes no " + what);
  };
  const Hdf5Handle access(hdf5.H5Pcreate(hdf5.H5P_CLS_FILE_ACCESS_ID_g), hdf5.H5Pclose);
  const SinkInfo info{&sink};
  if (!access || hdf5.H5Pset_driver(access.get(), sink_driver(hdf5), &info) < 0)
    return error(Errc::internal, target.string() + ": HDF5 takes no driver");
  constexpr unsigned truncate = 2;  // H5F_ACC_TRUNC is a macro that calls the library
  Hdf5Handle file(hdf5.H5Fcreate(target.c_str(), truncate, H5P_DEFAULT, access.get()), hdf5.H5Fclose);
  if (!file) return error(Errc::internal, target.string() + ": HDF5 makes no file");
  for (const auto& attribute : layout.attributes)
    if (!add_attribute(hdf5, file.get(), attribute)) return refused("attribute like " + in_quotes(attribute.name));
  for (const auto& group : layout.groups)
    if (!add_group(hdf5, file.get(), group)) return refused("group like " + in_quotes(group.name));
  std::vector<haddr_t> places;
  for (const auto& table : layout.tables) {
    places.push_back(add_table(hdf5, file.get(), table));
    if (places.back() == HADDR_UNDEF) return refused("table like " + in_quotes(table.name));
  }
  if (!file.close()) return error(Errc::internal, target.string() + ": HDF5 does not end its file");
  return places;
}

// The bytes of a table's numbers; 0 when a file cannot have as many.
std::uint64_t bytes_of(const Hdf5Table& table) {
  constexpr auto most = static_cast<std::uint64_t>(INT64_MAX) / 2;
  std::uint64_t bytes = size_of(table.type);
  for (const std::uint64_t side : table.shape) {
    if (side != 0 && bytes > most / side) return 0;
    bytes *= side;
  }
  return bytes;
}

}  // namespace

Result<Hdf5Output> Hdf5Output::create(const fs::path& target, const Hdf5Layout& layout) {
  std::vector<Place> tables;
  for (const auto& table : layout.tables) {
    tables.push_back({.at = 0, .bytes = bytes_of(table), .number_bytes = size_of(table.type)});
    if (table.shape.empty() || tables.back().bytes == 0)
      return error(Errc::usage,
                   target.string() + ": the table " + in_quotes(table.name) + " is empty, or too large for a file");
  }
  Hdf5Sink sink;
  BOOST_OUTCOME_TRY(places, describe(target, layout, sink));
  for (std::size_t i = 0; i < tables.size(); ++i) tables[i].at = places[i];
  TemporaryFile temporary(temporary_name_of_process(target));
  BOOST_OUTCOME_TRY(file, open_handle(temporary.path(), O_RDWR | O_CREAT | O_TRUNC, target));
  for (const auto& [number, page] : sink.pages.pages()) {
    const std::uint64_t at = number * Hdf5Pages::page_bytes;
    const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(page.size(), sink.end - at));
    BOOST_OUTCOME_TRYV(write_at(file.get(), std::span(page).first(size), at, target));
  }
  if (::ftruncate(file.get(), static_cast<off_t>(sink.end)) != 0) return io_error(target, "cannot write", errno);
  return Hdf5Output(target, std::move(temporary), std::move(file), std::move(tables));
}

Status Hdf5Output::write(std::size_t table, std::uint64_t first, std::span<const std::byte> numbers) const {
  const Place& place = tables_.at(table);
  const std::uint64_t all = place.bytes / place.number_bytes;
  if (first > all || numbers.size() > (all - first) * place.number_bytes)
    return error(Errc::internal, target_.string() + ": more numbers than the table has");
  return write_at(file_.get(), numbers, place.at + first * place.number_bytes, target_);
}

Result<std::uint64_t> Hdf5Output::commit() {
  BOOST_OUTCOME_TRY(bytes, size_of(file_, target_));
  if (!file_.close()) return io_error(target_, "cannot write", errno);
  BOOST_OUTCOME_TRYV(publish(temporary_.path(), target_));
  temporary_.keep();
  BOOST_OUTCOME_TRYV(sync_folder(target_.parent_path()));
  return bytes;
}

}  // namespace tessera
