#include "src/front/api/errors.h"

#include <exception>
#include <new>
#include <string>
#include <system_error>

#include "src/base/stopped.h"
#include "src/geometry/kernel/kernel.h"

namespace tessera {

void throw_failure(const Error& error) {
  static_assert(static_cast<int>(Cause::usage) == static_cast<int>(Errc::usage));
  static_assert(static_cast<int>(Cause::bad_input) == static_cast<int>(Errc::bad_input));
  static_assert(static_cast<int>(Cause::io) == static_cast<int>(Errc::io));
  static_assert(static_cast<int>(Cause::corrupt) == static_cast<int>(Errc::corrupt));
  static_assert(static_cast<int>(Cause::not_delaunay) == static_cast<int>(Errc::not_delaunay));
  static_assert(static_cast<int>(Cause::memory) == static_cast<int>(Errc::memory));
  static_assert(static_cast<int>(Cause::interrupted) == static_cast<int>(Errc::interrupted));
  static_assert(static_cast<int>(Cause::internal) == static_cast<int>(Errc::internal));
  throw Failure(static_cast<Cause>(error.code), error.where);
}

void rethrow_as_failure() {
  try {
    throw;
  } catch (const Failure&) {
    throw;
  } catch (const KernelFull& full) {
    throw Failure(Cause::memory, std::string("a tile ") + full.what());
  } catch (const Stopped&) {
    throw Failure(Cause::interrupted, "stopped, as was requested");
  } catch (const std::bad_alloc&) {
    throw Failure(Cause::memory, "the system has no more memory to give");
  } catch (const std::system_error& refused) {
    throw Failure(Cause::io, refused.what());
  } catch (const std::exception& other) {
    throw Failure(Cause::internal, std::string("unexpected: ") + other.what());
  }
}

}  // namespace tessera
