#include "src/base/hdf5/hdf5_library.h"

#include <dlfcn.h>

#include <string>

#include "src/base/default_arithmetic.h"

namespace tessera {
namespace {

Result<Hdf5Library> load() {
  const DefaultArithmetic kept;
  // HDF5 is never unloaded, because it registers what it does at the end of the program.
  void* const handle = ::dlopen(TESSERA_HDF5_SONAME, RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr)
    return error(Errc::io, std::string("HDF5 needs its library (Debian's package libhdf5-103-1): ") + ::dlerror());
  Hdf5Library hdf5;
  const char* missing = nullptr;
  const auto find = [&]<class Function>(Function& function, const char* name) {
    function = reinterpret_cast<Function>(::dlsym(handle, name));
    if (function == nullptr) missing = name;
  };
#define TESSERA_HDF5_FIND(name) find(hdf5.name, #name);
  TESSERA_HDF5_FUNCTIONS(TESSERA_HDF5_FIND)
#undef TESSERA_HDF5_FIND
  if (missing != nullptr) return error(Errc::io, std::string(TESSERA_HDF5_SONAME) + " has no function " + missing);
  unsigned major = 0, minor = 0, release = 0;
  if (hdf5.H5open() < 0 || hdf5.H5get_libversion(&major, &minor, &release) < 0)
    return error(Errc::io, std::string(TESSERA_HDF5_SONAME) + " cannot be used");
  if (major != H5_VERS_MAJOR || minor != H5_VERS_MINOR)
    return error(Errc::io, std::string(TESSERA_HDF5_SONAME) + " is HDF5 " + std::to_string(major) + "." +
                               std::to_string(minor) + ", but " + std::to_string(H5_VERS_MAJOR) + "." +
                               std::to_string(H5_VERS_MINOR) + " is needed");
  const auto look_up = [&](hid_t& variable, const char* name) {
    const auto* found = static_cast<const hid_t*>(::dlsym(handle, name));
    if (found == nullptr) {
      missing = name;
    } else {
      variable = *found;
    }
  };
#define TESSERA_HDF5_LOOK_UP(name) look_up(hdf5.name, #name);
  TESSERA_HDF5_VARIABLES(TESSERA_HDF5_LOOK_UP)
#undef TESSERA_HDF5_LOOK_UP
  if (missing != nullptr) return error(Errc::io, std::string(TESSERA_HDF5_SONAME) + " has no variable " + missing);
  hdf5.H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  hdf5.H5PLset_loading_state(0);  // a file names its filters, and must not choose code to run
  return hdf5;
}

}  // namespace

Result<const Hdf5Library*> hdf5_library() {
  static const Result<Hdf5Library> hdf5 = load();
  if (!hdf5) return hdf5.error();
  return &hdf5.value();
}

std::mutex& hdf5_mutex() {
  static std::mutex mutex;
  return mutex;
}

hid_t hdf5_memory_type(const Hdf5Library& hdf5, AttributeType type) {
  using enum AttributeType;
  switch (type) {
    case u8:
      return hdf5.H5T_NATIVE_UINT8_g;
    case i8:
      return hdf5.H5T_NATIVE_INT8_g;
    case u16:
      return hdf5.H5T_NATIVE_UINT16_g;
    case i16:
      return hdf5.H5T_NATIVE_INT16_g;
    case u32:
      return hdf5.H5T_NATIVE_UINT32_g;
    case i32:
      return hdf5.H5T_NATIVE_INT32_g;
    case u64:
      return hdf5.H5T_NATIVE_UINT64_g;
    case i64:
      return hdf5.H5T_NATIVE_INT64_g;
    case f32:
      return hdf5.H5T_NATIVE_FLOAT_g;
    case f64:
      return hdf5.H5T_NATIVE_DOUBLE_g;
  }
  return -1;
}

}  // namespace tessera
