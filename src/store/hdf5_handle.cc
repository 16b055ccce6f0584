#include "src/store/hdf5_handle.h"

#include <fcntl.h>
#include <unistd.h>

namespace tessera::store {

std::string hdf5_reason() {
  std::string reason = "HDF5 failed";
  const auto take = [](unsigned, const H5E_error2_t* entry, void* data) -> herr_t {
    if (entry->desc != nullptr) *static_cast<std::string*>(data) = std::string("HDF5: ") + entry->desc;
    return 1;  // walking upward, the first entry is the innermost: stop
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take, &reason);
  return reason;
}

hid_t hdf5_type(AttributeType type) {
  switch (type) {
    case AttributeType::u8:
      return H5T_STD_U8LE;
    case AttributeType::i8:
      return H5T_STD_I8LE;
    case AttributeType::u16:
      return H5T_STD_U16LE;
    case AttributeType::i16:
      return H5T_STD_I16LE;
    case AttributeType::u32:
      return H5T_STD_U32LE;
    case AttributeType::i32:
      return H5T_STD_I32LE;
    case AttributeType::u64:
      return H5T_STD_U64LE;
    case AttributeType::i64:
      return H5T_STD_I64LE;
    case AttributeType::f32:
      return H5T_IEEE_F32LE;
    case AttributeType::f64:
      return H5T_IEEE_F64LE;
  }
  return -1;
}

Hdf5Handle dataset_properties() {
  Hdf5Handle properties = property_list(H5P_DATASET_CREATE);
  H5Pset_obj_track_times(properties, false);
  return properties;
}

VtkHdfFile create_vtkhdf(const std::string& path, const MemoryFile& memory) {
  VtkHdfFile result;
  const Hdf5Handle access = property_list(H5P_FILE_ACCESS);
  // 1.10 is the oldest format with virtual datasets, and its metadata carry checksums; VTK 9.1 reads it.
  H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  // Big arrays start on a page, so that writing them touches no page twice.
  H5Pset_alignment(access, 65536, 4096);
  const Hdf5Handle creation = property_list(H5P_FILE_CREATE);
  H5Pset_obj_track_times(creation, false);  // of the root group: equal tiles are equal bytes
  H5Pset_fapl_sec2(access);
  result.file = {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose};
  if (!result.file.ok()) return result;
  // Nothing is written before the first flush: from here on, HDF5's descriptor is the memory's.
  void* descriptor = nullptr;
  if (H5Fget_vfd_handle(result.file, access, &descriptor) < 0 ||
      ::dup3(memory.fd(), *static_cast<int*>(descriptor), O_CLOEXEC) < 0)
    return result;

  // The order of creation is kept, so that attributes come back in the order of the schema.
  const Hdf5Handle ordered = property_list(H5P_GROUP_CREATE);
  H5Pset_obj_track_times(ordered, false);
  H5Pset_link_creation_order(ordered, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  result.group = {H5Gcreate2(result.file, "VTKHDF", H5P_DEFAULT, ordered, H5P_DEFAULT), H5Gclose};
  if (!result.group.ok()) return result;

  const Hdf5Handle pair = space_of({2});
  const std::int64_t version[2] = {1, 0};
  const Hdf5Handle version_attribute{H5Acreate2(result.group, "Version", H5T_STD_I64LE, pair, H5P_DEFAULT, H5P_DEFAULT),
                                     H5Aclose};
  if (H5Awrite(version_attribute, H5T_NATIVE_INT64, version) < 0) return result;
  const Hdf5Handle text{H5Tcopy(H5T_C_S1), H5Tclose};  // VTK wants a fixed-length ASCII string
  H5Tset_size(text, 16);
  H5Tset_strpad(text, H5T_STR_NULLPAD);
  const Hdf5Handle scalar{H5Screate(H5S_SCALAR), H5Sclose};
  const Hdf5Handle type_attribute{H5Acreate2(result.group, "Type", text, scalar, H5P_DEFAULT, H5P_DEFAULT), H5Aclose};
  if (H5Awrite(type_attribute, text, "UnstructuredGrid") < 0) return result;

  result.point_data = {H5Gcreate2(result.group, "PointData", H5P_DEFAULT, ordered, H5P_DEFAULT), H5Gclose};
  result.cell_data = {H5Gcreate2(result.group, "CellData", H5P_DEFAULT, ordered, H5P_DEFAULT), H5Gclose};
  return result;
}

bool write_counts(hid_t group, const char* name, const std::vector<std::int64_t>& values) {
  const Hdf5Handle space = space_of({values.size()});
  const Hdf5Handle properties = dataset_properties();
  const Hdf5Handle dataset{H5Dcreate2(group, name, H5T_STD_I64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT),
                           H5Dclose};
  if (!dataset.ok()) return false;
  return values.empty() || H5Dwrite(dataset, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0;
}

}  // namespace tessera::store
