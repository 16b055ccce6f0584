#include "src/input/reader.h"

#include <algorithm>
#include <array>
#include <utility>

#include "src/base/option.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/column_names.h"
#include "src/input/e57/e57_reader.h"
#include "src/input/ept/ept_reader.h"
#include "src/input/fits/fits_reader.h"
#include "src/input/format.h"
#include "src/input/las/las_reader.h"
#include "src/input/mesh/obj_reader.h"
#include "src/input/mesh/off_reader.h"
#include "src/input/mesh/stl_reader.h"
#include "src/input/npy/npy_reader.h"
#include "src/input/pcd/pcd_reader.h"
#include "src/input/ply/ply_reader.h"
#include "src/input/scans/pts_reader.h"
#include "src/input/scans/ptx_reader.h"
#include "src/input/snapshot/gadget.h"
#include "src/input/snapshot/gadget_hdf5.h"
#include "src/input/snapshot/tipsy.h"
#include "src/input/text/text_reader.h"

namespace tessera {
FileInfo info_of(const ByteSource& source, std::string format) {
  FileInfo info;
  info.path = source.path();
  info.format = std::move(format);
  info.packing = source.packing();
  info.bytes = source.stored_bytes();
  info.content_bytes = source.size();
  info.modified_ns = source.modified_ns();
  return info;
}

Result<std::unique_ptr<PointReader>> open_reader(std::unique_ptr<ByteSource> source,
                                                 const std::vector<Attribute>& attributes, const ReadHints& hints) {
  const auto path = source->path();
  if (source->size() == 0) return error(Errc::bad_input, path.string() + ": is empty");
  std::array<std::byte, format_bytes> begin{};
  const auto there =
      std::span(begin).first(static_cast<std::size_t>(std::min<std::uint64_t>(begin.size(), source->size())));
  BOOST_OUTCOME_TRYV(source->read(0, there));
  const FileFormat format = format_of(there, source->content_name(), source->size());
  if (are_entries(hints.columns) && (format == FileFormat::npy || format == FileFormat::text))
    return error(Errc::usage, path.string() + ": is no FITS table; " + option("columns") +
                                  " names its columns in order, as p,y,x,z");
  switch (format) {
    case FileFormat::las:
      return open_las(std::move(source), attributes, hints);
    case FileFormat::npy:
      return open_npy(std::move(source), attributes, hints);
    case FileFormat::ply:
      return open_ply(std::move(source), attributes);
    case FileFormat::off:
      return open_off(std::move(source), attributes);
    case FileFormat::obj:
      return open_obj(std::move(source), attributes);
    case FileFormat::stl:
      return open_stl(std::move(source), attributes);
    case FileFormat::e57:
      return open_e57(std::move(source), attributes, hints);
    case FileFormat::ept:
      return open_ept(std::move(source), attributes, hints);
    case FileFormat::pcd:
      return open_pcd(std::move(source), attributes);
    case FileFormat::ptx:
      return open_ptx(std::move(source), attributes);
    case FileFormat::pts:
      return open_pts(std::move(source), attributes, hints);
    case FileFormat::gadget:
      return snapshot::open_gadget(std::move(source), attributes, hints);
    case FileFormat::hdf5:
      return snapshot::open_gadget_hdf5(std::move(source), attributes, hints);
    case FileFormat::tipsy:
      return snapshot::open_tipsy(std::move(source), attributes, hints);
    case FileFormat::fits:
      return fits::open_fits(std::move(source), attributes, hints);
    case FileFormat::text:
      return open_text(std::move(source), attributes, hints);
    case FileFormat::gzip:
    case FileFormat::zstd:
      return error(Errc::bad_input, path.string() + ": is compressed twice; unpack it once");
    case FileFormat::unknown:
      break;
  }
  return unknown_format(path);
}

Result<std::unique_ptr<PointReader>> open_reader(const std::filesystem::path& path,
                                                 const std::vector<Attribute>& attributes, const ReadHints& hints) {
  BOOST_OUTCOME_TRY(source, open_file(path));
  return open_reader(std::move(source), attributes, hints);
}

}  // namespace tessera
