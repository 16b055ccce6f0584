#include "src/input/snapshot/hdf5_file.h"

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <utility>

#include "src/base/hdf5/hdf5_library.h"
#include "src/base/printable.h"
#include "src/input/bytes/number_type.h"

namespace tessera::snapshot {
namespace {

using Call = const Hdf5Library*;

// What HDF5 reads: the driver of these files.
struct OpenFile {
  H5FD_t common;  // first: HDF5 sees this part alone
  const ByteSource* source;
  haddr_t end_of_address_space;
};

struct DriverInfo {
  const ByteSource* source;
};

const OpenFile* ours(const H5FD_t* file) { return reinterpret_cast<const OpenFile*>(file); }

H5FD_t* open_driver(const char*, unsigned, hid_t fapl, haddr_t) {
  const auto library = hdf5_library();
  const auto* info = static_cast<const DriverInfo*>(library.value()->H5Pget_driver_info(fapl));
  if (info == nullptr) return nullptr;
  auto* file = new OpenFile{};
  file->source = info->source;
  return &file->common;
}

herr_t close_driver(H5FD_t* file) {
  delete reinterpret_cast<OpenFile*>(file);
  return 0;
}

int compare(const H5FD_t* a, const H5FD_t* b) {
  return ours(a)->source < ours(b)->source ? -1 : ours(b)->source < ours(a)->source;
}

herr_t query(const H5FD_t*, unsigned long* flags) {
  *flags = 0;
  return 0;
}

haddr_t get_eoa(const H5FD_t* file, H5FD_mem_t) { return ours(file)->end_of_address_space; }
herr_t set_eoa(H5FD_t* file, H5FD_mem_t, haddr_t address) {
  reinterpret_cast<OpenFile*>(file)->end_of_address_space = address;
  return 0;
}
haddr_t get_eof(const H5FD_t* file, H5FD_mem_t) { return ours(file)->source->size(); }

herr_t read_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, void* buffer) {
  const ByteSource& source = *ours(file)->source;
  if (at > source.size() || size > source.size() - at) return -1;
  return source.read(at, std::span(static_cast<std::byte*>(buffer), size)).has_value() ? 0 : -1;
}

herr_t write_bytes(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, std::size_t, const void*) { return -1; }

hid_t driver(Call hdf5) {
  static const H5FD_class_t driver = [] {
    H5FD_class_t made{};
    made.name = "tessera";
    made.maxaddr = static_cast<haddr_t>(INT64_MAX);
    made.fc_degree = H5F_CLOSE_STRONG;
    made.fapl_size = sizeof(DriverInfo);
    made.open = open_driver;
    made.close = close_driver;
    made.cmp = compare;
    made.query = query;
    made.get_eoa = get_eoa;
    made.set_eoa = set_eoa;
    made.get_eof = get_eof;
    made.read = read_bytes;
    made.write = write_bytes;
    return made;
  }();
  static const hid_t id = hdf5->H5FDregister(&driver);
  return id;
}

// Whether the bits of a number lie within its bytes. HDF5 does not check that when it opens a file, and converts
// numbers of a damaged type by reading behind their end.
bool has_its_bits(Call hdf5, hid_t type, bool floating) {
  const std::size_t bits = 8 * hdf5->H5Tget_size(type), precision = hdf5->H5Tget_precision(type);
  const int offset = hdf5->H5Tget_offset(type);
  if (offset < 0 || precision == 0 || precision > bits || static_cast<std::size_t>(offset) > bits - precision)
    return false;
  if (!floating) return true;
  std::size_t sign = 0, exponent = 0, exponent_bits = 0, mantissa = 0, mantissa_bits = 0;
  if (hdf5->H5Tget_fields(type, &sign, &exponent, &exponent_bits, &mantissa, &mantissa_bits) < 0) return false;
  const auto fits = [&](std::size_t at, std::size_t size) { return size > 0 && at < bits && size <= bits - at; };
  return fits(sign, 1) && fits(exponent, exponent_bits) && fits(mantissa, mantissa_bits);
}

// The type of numbers of HDF5, if it is one of ours. Shorter floats become floats of four bytes.
std::optional<AttributeType> type_in_file(Call hdf5, hid_t type) {
  const H5T_class_t kind = hdf5->H5Tget_class(type);
  const std::size_t size = hdf5->H5Tget_size(type);
  if (kind != H5T_FLOAT && kind != H5T_INTEGER) return std::nullopt;
  if (!has_its_bits(hdf5, type, kind == H5T_FLOAT)) return std::nullopt;
  if (kind == H5T_FLOAT) return number_type(NumberKind::floating, std::max<std::size_t>(size, sizeof(float)));
  return number_type(hdf5->H5Tget_sign(type) == H5T_SGN_NONE ? NumberKind::without_sign : NumberKind::with_sign, size);
}

// One or two dimensions.
std::optional<std::array<hsize_t, 2>> extent(Call hdf5, hid_t space) {
  const int dimensions = hdf5->H5Sget_simple_extent_ndims(space);
  std::array<hsize_t, 2> extent{0, 1};
  if (dimensions < 1 || dimensions > 2 || hdf5->H5Sget_simple_extent_dims(space, extent.data(), nullptr) < 0)
    return std::nullopt;
  return extent;
}

// Why a table with these properties is not read; "" if it is.
std::string why_not(Call hdf5, hid_t properties) {
  constexpr std::array<H5Z_filter_t, 5> known{H5Z_FILTER_DEFLATE, H5Z_FILTER_SHUFFLE, H5Z_FILTER_FLETCHER32,
                                              H5Z_FILTER_NBIT, H5Z_FILTER_SCALEOFFSET};
  const H5D_layout_t layout = hdf5->H5Pget_layout(properties);
  if (layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED)
    return "takes its numbers from other files";
  if (layout == H5D_CONTIGUOUS && hdf5->H5Pget_external_count(properties) != 0)
    return "takes its numbers from other files";
  if (layout != H5D_CHUNKED) return "";
  std::array<hsize_t, 2> chunk{1, 1};
  constexpr hsize_t numbers_max = hsize_t{1} << 26;
  if (hdf5->H5Pget_chunk(properties, 2, chunk.data()) < 1 || chunk[0] > numbers_max || chunk[1] > numbers_max ||
      chunk[0] * chunk[1] > numbers_max)
    return "has chunks of more than " + std::to_string(numbers_max) + " numbers";
  const int filters = hdf5->H5Pget_nfilters(properties);
  for (int i = 0; i < filters; ++i) {
    unsigned flags = 0, info = 0;
    std::size_t values = 0;
    std::array<char, 64> name{};
    const H5Z_filter_t filter = hdf5->H5Pget_filter2(properties, static_cast<unsigned>(i), &flags, &values, nullptr,
                                                     name.size() - 1, name.data(), &info);
    if (std::find(known.begin(), known.end(), filter) == known.end())
      return "is compressed by filter " + std::to_string(filter) + " (" + in_quotes(name.data()) +
             "), which is not read; rewrite the file with 'h5repack -f GZIP=4'";
  }
  return "";
}

}  // namespace

struct Hdf5File::Impl {
  Call hdf5;
  std::string path;
  hid_t file = -1;
  std::map<std::string, Hdf5Handle> tables = {};  // that were read; while a table is open, HDF5 keeps its last chunks
  ~Impl() {
    const std::lock_guard lock(hdf5_mutex());
    tables.clear();
    if (file >= 0) hdf5->H5Fclose(file);
  }

  // Follows hard links alone, so that a name cannot lead to another file.
  bool is_own_link(hid_t at, const char* name) const {
    H5L_info_t info{};
    return hdf5->H5Lexists(at, name, H5P_DEFAULT) > 0 && hdf5->H5Lget_info(at, name, &info, H5P_DEFAULT) >= 0 &&
           info.type == H5L_TYPE_HARD;
  }
  Hdf5Handle group(const std::string& name) const {
    return {is_own_link(file, name.c_str()) ? hdf5->H5Gopen2(file, name.c_str(), H5P_DEFAULT) : -1, hdf5->H5Gclose};
  }

  // The table, opened once. Unpacked chunks are kept up to some bytes, because batches are smaller than chunks. Returns
  // -1 if there is none.
  hid_t table(const std::string& group_name, const std::string& name) {
    const std::string path = group_name + "/" + name;
    if (const auto found = tables.find(path); found != tables.end()) return found->second.get();
    const Hdf5Handle in = group(group_name);
    if (!in || !is_own_link(in.get(), name.c_str())) return -1;
    constexpr std::size_t places = 521, kept_bytes = std::size_t{32} << 20;
    const Hdf5Handle access(hdf5->H5Pcreate(hdf5->H5P_CLS_DATASET_ACCESS_ID_g), hdf5->H5Pclose);
    if (!access || hdf5->H5Pset_chunk_cache(access.get(), places, kept_bytes, 1) < 0) return -1;
    Hdf5Handle opened(hdf5->H5Dopen2(in.get(), name.c_str(), access.get()), hdf5->H5Dclose);
    const hid_t id = opened.get();
    if (opened) tables.emplace(path, std::move(opened));
    return id;
  }

  template <class Number>
  std::optional<std::vector<Number>> attribute(const std::string& group_name, const std::string& name,
                                               hid_t type) const {
    const std::lock_guard lock(hdf5_mutex());
    const Hdf5Handle in = group(group_name);
    return attribute_of<Number>(in.get(), name, type);
  }

  // The same of an open group or table. REQUIRES: the mutex is held.
  template <class Number>
  std::optional<std::vector<Number>> attribute_of(hid_t in, const std::string& name, hid_t type) const {
    if (in < 0 || hdf5->H5Aexists(in, name.c_str()) <= 0) return std::nullopt;
    const Hdf5Handle attribute(hdf5->H5Aopen(in, name.c_str(), H5P_DEFAULT), hdf5->H5Aclose);
    if (!attribute) return std::nullopt;
    const Hdf5Handle space(hdf5->H5Aget_space(attribute.get()), hdf5->H5Sclose),
        stored(hdf5->H5Aget_type(attribute.get()), hdf5->H5Tclose);
    if (!space || !stored || !type_in_file(hdf5, stored.get())) return std::nullopt;
    const bool single = hdf5->H5Sget_simple_extent_ndims(space.get()) == 0;
    const auto size = single ? std::optional(std::array<hsize_t, 2>{1, 1}) : extent(hdf5, space.get());
    constexpr hsize_t most = 64;
    if (!size || (*size)[0] > most || (*size)[1] > most) return std::nullopt;
    std::vector<Number> numbers((*size)[0] * (*size)[1]);
    if (hdf5->H5Aread(attribute.get(), type, numbers.data()) < 0) return std::nullopt;
    return numbers;
  }
};

Hdf5File::Hdf5File(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Hdf5File::Hdf5File(Hdf5File&&) noexcept = default;
Hdf5File& Hdf5File::operator=(Hdf5File&&) noexcept = default;
Hdf5File::~Hdf5File() = default;

Result<Hdf5File> Hdf5File::open(const ByteSource& source) {
  const std::string path = source.path().string();
  const auto library = hdf5_library();
  if (!library) return error(library.error().code, path + ": " + library.error().where);
  const std::lock_guard lock(hdf5_mutex());
  Call hdf5 = library.value();
  const Hdf5Handle access(hdf5->H5Pcreate(hdf5->H5P_CLS_FILE_ACCESS_ID_g), hdf5->H5Pclose);
  const DriverInfo info{&source};
  if (!access || hdf5->H5Pset_driver(access.get(), driver(hdf5), &info) < 0)
    return error(Errc::internal, path + ": HDF5 takes no driver");
  constexpr unsigned read_only = 0;  // H5F_ACC_RDONLY is a macro that calls the library
  const hid_t file = hdf5->H5Fopen(path.c_str(), read_only, access.get());
  if (file < 0) return error(Errc::bad_input, path + ": is no HDF5 file that can be read, or is damaged");
  auto impl = std::make_unique<Impl>();
  impl->hdf5 = hdf5;
  impl->path = path;
  impl->file = file;
  return Hdf5File(std::move(impl));
}

bool Hdf5File::has_group(const std::string& name) const {
  const std::lock_guard lock(hdf5_mutex());
  return static_cast<bool>(impl_->group(name));
}

std::optional<std::vector<double>> Hdf5File::numbers(const std::string& group, const std::string& attribute) const {
  return impl_->attribute<double>(group, attribute, impl_->hdf5->H5T_NATIVE_DOUBLE_g);
}

std::optional<std::vector<std::uint64_t>> Hdf5File::counts(const std::string& group,
                                                           const std::string& attribute) const {
  return impl_->attribute<std::uint64_t>(group, attribute, impl_->hdf5->H5T_NATIVE_UINT64_g);
}

std::optional<double> Hdf5File::number_of_table(const std::string& group, const std::string& table,
                                                const std::string& attribute) const {
  const std::lock_guard lock(hdf5_mutex());
  const auto numbers =
      impl_->attribute_of<double>(impl_->table(group, table), attribute, impl_->hdf5->H5T_NATIVE_DOUBLE_g);
  return numbers && numbers->size() == 1 ? std::optional(numbers->front()) : std::nullopt;
}

Result<std::vector<Dataset>> Hdf5File::datasets(const std::string& group_name) const {
  const std::lock_guard lock(hdf5_mutex());
  Call hdf5 = impl_->hdf5;
  const Hdf5Handle group = impl_->group(group_name);
  H5G_info_t info{};
  if (!group || hdf5->H5Gget_info(group.get(), &info) < 0)
    return error(Errc::bad_input, impl_->path + ": its group " + group_name + " cannot be read");
  constexpr hsize_t links_max = 4096;
  if (info.nlinks > links_max)
    return error(Errc::bad_input, impl_->path + ": its group " + group_name + " has " + std::to_string(info.nlinks) +
                                      " members; at most " + std::to_string(links_max) + " are read");
  std::vector<Dataset> found;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    std::array<char, 256> name{};
    const auto length = hdf5->H5Lget_name_by_idx(group.get(), ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(),
                                                 name.size(), H5P_DEFAULT);
    if (length <= 0 || static_cast<std::size_t>(length) >= name.size()) continue;
    if (!impl_->is_own_link(group.get(), name.data())) continue;
    const Hdf5Handle table(hdf5->H5Dopen2(group.get(), name.data(), H5P_DEFAULT), hdf5->H5Dclose);
    if (!table) continue;  // a group
    const Hdf5Handle space(hdf5->H5Dget_space(table.get()), hdf5->H5Sclose),
        stored(hdf5->H5Dget_type(table.get()), hdf5->H5Tclose),
        properties(hdf5->H5Dget_create_plist(table.get()), hdf5->H5Pclose);
    if (!space || !stored || !properties) continue;
    const auto type = type_in_file(hdf5, stored.get());
    const auto size = extent(hdf5, space.get());
    constexpr hsize_t columns_max = 64;
    if (!type || !size || (*size)[1] > columns_max) continue;
    if (const std::string why = why_not(hdf5, properties.get()); !why.empty())
      return error(Errc::bad_input,
                   impl_->path + ": its table " + in_quotes(group_name + "/" + name.data()) + " " + why);
    found.push_back(
        {.name = name.data(), .rows = (*size)[0], .columns = static_cast<std::size_t>((*size)[1]), .type = *type});
  }
  return found;
}

Status Hdf5File::read(const std::string& group_name, const Dataset& dataset, std::uint64_t first_row, std::size_t rows,
                      std::span<std::byte> out) const {
  const std::lock_guard lock(hdf5_mutex());
  Call hdf5 = impl_->hdf5;
  const auto bad = [&](const char* what) {
    return error(Errc::bad_input,
                 impl_->path + ": its table " + in_quotes(group_name + "/" + dataset.name) + " " + what);
  };
  const hid_t table = impl_->table(group_name, dataset.name);
  if (table < 0) return bad("has gone");
  const Hdf5Handle space(hdf5->H5Dget_space(table), hdf5->H5Sclose);
  const int dimensions = space ? hdf5->H5Sget_simple_extent_ndims(space.get()) : 0;
  if (dimensions < 1 || dimensions > 2) return bad("has another shape than before");
  const std::array<hsize_t, 2> start{first_row, 0}, count{rows, dataset.columns};
  const Hdf5Handle memory(hdf5->H5Screate_simple(dimensions, count.data(), nullptr), hdf5->H5Sclose);
  if (!memory ||
      hdf5->H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) < 0)
    return bad("has fewer rows than before");
  if (out.size() != rows * dataset.columns * size_of(dataset.type))
    return error(Errc::internal, "a buffer has another size than its rows");
  if (hdf5->H5Dread(table, hdf5_memory_type(*hdf5, dataset.type), memory.get(), space.get(), H5P_DEFAULT, out.data()) <
      0)
    return bad("cannot be read: it is damaged or cut off");
  return success();
}

}  // namespace tessera::snapshot
