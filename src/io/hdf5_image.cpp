#include "hdf5_image.hpp"

#include <hdf5.h>

#include <array>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/error.hpp"

namespace lumesh::io {

namespace {

void require(bool done) {
  if (!done) throw Error(ErrorKind::kMemory, "HDF5 has no memory for the file; close other programs");
}

/// An open HDF5 object.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);

  Handle(hid_t id, Close close) : id_(id), close_(close) { require(id >= 0); }
  ~Handle() { close_(id_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  [[nodiscard]] hid_t id() const { return id_; }

 private:
  hid_t id_;
  Close close_;
};

/// Keeps HDF5 from printing its own account of a failure while the object lives.
class Silence {
 public:
  Silence() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Silence() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

hid_t open_in_memory() {
  constexpr std::size_t kGrowthBytes = std::size_t{1} << 20;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  require(H5Pset_fapl_core(access.id(), kGrowthBytes, 0) >= 0);
  return H5Fcreate("lumesh", H5F_ACC_TRUNC, H5P_DEFAULT, access.id());  // A name without a file.
}

void add_array(hid_t file, const std::string& name, hid_t stored, hid_t given, const void* values,
               std::array<hsize_t, 2> shape) {
  const Handle space(H5Screate_simple(shape[1] == 1 ? 1 : 2, shape.data(), nullptr), H5Sclose);
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  require(H5Pset_obj_track_times(creation.id(), false) >= 0);
  require(H5Pset_fill_time(creation.id(), H5D_FILL_TIME_NEVER) >= 0);
  const Handle array(
      H5Dcreate2(file, name.c_str(), stored, space.id(), H5P_DEFAULT, creation.id(), H5P_DEFAULT), H5Dclose);
  require(H5Dwrite(array.id(), given, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
}

template <class Value>
std::array<hsize_t, 2> shape_of(std::span<const Value> values, std::size_t columns) {
  LUMESH_ASSERT(columns > 0 && values.size() % columns == 0);
  return {values.size() / columns, columns};
}

}  // namespace

struct Hdf5Image::File {
  Silence silence;  // First, so that it outlives the file.
  Handle handle{open_in_memory(), H5Fclose};
};

Hdf5Image::Hdf5Image() : file_(std::make_unique<File>()) {}

Hdf5Image::~Hdf5Image() = default;

void Hdf5Image::add(const std::string& name, std::span<const double> values, std::size_t columns) {
  add_array(file_->handle.id(), name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data(),
            shape_of(values, columns));
}

void Hdf5Image::add(const std::string& name, std::span<const std::int32_t> values, std::size_t columns) {
  add_array(file_->handle.id(), name, H5T_STD_I32LE, H5T_NATIVE_INT32, values.data(),
            shape_of(values, columns));
}

std::vector<std::byte> Hdf5Image::finish() {
  const hid_t file = file_->handle.id();
  require(H5Fflush(file, H5F_SCOPE_LOCAL) >= 0);
  const ssize_t size = H5Fget_file_image(file, nullptr, 0);
  require(size > 0);
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  require(H5Fget_file_image(file, bytes.data(), bytes.size()) == size);
  file_.reset();
  return bytes;
}

}  // namespace lumesh::io
