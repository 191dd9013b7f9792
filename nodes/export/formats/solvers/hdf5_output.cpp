#include "nodes/export/formats/solvers/hdf5_output.h"

#include <fcntl.h>
#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <mutex>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"

namespace terrazzo::exporting {
namespace {

// Bytes of a row that is compressed by itself. The format's limit is 4 GiB.
constexpr std::uint64_t kSmallestChunk = 4096, kLargestChunk = std::uint64_t{1} << 31;

std::mutex& library_mutex() {
  static std::mutex one;
  return one;
}

// Closes what the library has opened.
class Hdf5Handle {
 public:
  Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  operator hid_t() const { return id_; }
  // False if closing failed, which may be the first report of a full disk.
  bool close() {
    const herr_t result = id_ >= 0 ? close_(id_) : -1;
    id_ = -1;
    return result >= 0;
  }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// Where the library's bytes go. The library crashes at the end of the process if it could not write all of a
// file, so it is never told: after a failure, further bytes are dropped, and `finish` reports the reason.
struct Hdf5Disk {
  H5FD_t base;  // must be first
  int descriptor;
  haddr_t end, used;
};
int disk_error = 0;  // errno of the first failure; guarded by library_mutex

Hdf5Disk* disk_of(H5FD_t* file) { return reinterpret_cast<Hdf5Disk*>(file); }
const Hdf5Disk* disk_of(const H5FD_t* file) { return reinterpret_cast<const Hdf5Disk*>(file); }

H5FD_t* open_disk(const char* name, unsigned, hid_t, haddr_t) {
  disk_error = 0;
  const int descriptor = ::open(name, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    disk_error = errno;
    return nullptr;
  }
  auto* disk = new Hdf5Disk{};
  disk->descriptor = descriptor;
  return &disk->base;
}

herr_t close_disk(H5FD_t* file) {
  if (::close(disk_of(file)->descriptor) != 0 && disk_error == 0) disk_error = errno;
  delete disk_of(file);
  return 0;
}

herr_t write_disk(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, const void* bytes) {
  Hdf5Disk* disk = disk_of(file);
  const char* from = static_cast<const char*>(bytes);
  disk->used = std::max<haddr_t>(disk->used, at + size);
  while (size > 0 && disk_error == 0) {
    const ssize_t count = ::pwrite(disk->descriptor, from, size, at);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      disk_error = count < 0 ? errno : ENOSPC;
      break;
    }
    from += count;
    at += count;
    size -= count;
  }
  return 0;
}

herr_t read_disk(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, void* bytes) {
  char* to = static_cast<char*>(bytes);
  while (size > 0) {
    const ssize_t count = ::pread(disk_of(file)->descriptor, to, size, at);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    to += count;
    at += count;
    size -= count;
  }
  std::memset(to, 0, size);  // beyond the end, or lost
  return 0;
}

herr_t truncate_disk(H5FD_t* file, hid_t, hbool_t) {
  Hdf5Disk* disk = disk_of(file);
  if (disk->used != disk->end && ::ftruncate(disk->descriptor, disk->end) != 0 && disk_error == 0)
    disk_error = errno;
  disk->used = disk->end;
  return 0;
}

// Access to files through these functions.
hid_t disk_access() {
  static const H5FD_class_t kDriver = [] {
    H5FD_class_t d{};
    d.name = "terrazzo";
    d.maxaddr = (haddr_t{1} << 62) - 1;
    d.fc_degree = H5F_CLOSE_STRONG;
    d.open = open_disk;
    d.close = close_disk;
    d.write = write_disk;
    d.read = read_disk;
    d.truncate = truncate_disk;
    d.query = [](const H5FD_t*, unsigned long* flags) -> herr_t {
      *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_ACCUMULATE_METADATA;
      return 0;
    };
    d.get_eoa = [](const H5FD_t* f, H5FD_mem_t) { return disk_of(f)->end; };
    d.set_eoa = [](H5FD_t* f, H5FD_mem_t, haddr_t end) -> herr_t {
      disk_of(f)->end = end;
      return 0;
    };
    d.get_eof = [](const H5FD_t* f, H5FD_mem_t) { return std::max(disk_of(f)->used, disk_of(f)->end); };
    const H5FD_mem_t map[] = H5FD_FLMAP_DICHOTOMY;
    std::copy(std::begin(map), std::end(map), d.fl_map);
    return d;
  }();
  static const hid_t driver = H5FDregister(&kDriver);
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_driver(access, driver, nullptr);
  return access;
}

hid_t hdf5_type(Hdf5Type type) {
  switch (type) {
    case Hdf5Type::Int32:
      return H5T_STD_I32LE;
    case Hdf5Type::UInt32:
      return H5T_STD_U32LE;
    case Hdf5Type::Int64:
      return H5T_STD_I64LE;
    case Hdf5Type::UInt64:
      return H5T_STD_U64LE;
    case Hdf5Type::UInt8:
      return H5T_STD_U8LE;
    case Hdf5Type::Float:
      return H5T_IEEE_F32LE;
  }
  return -1;
}

}  // namespace

struct Hdf5Output::State {
  std::filesystem::path path;
  std::unique_lock<std::mutex> lock{library_mutex()};
  Hdf5Handle file{-1, H5Fclose};
  Hdf5Handle links{-1, H5Pclose};

  State(const std::filesystem::path& p, hid_t f, hid_t l, std::unique_lock<std::mutex> held)
      : path(p), lock(std::move(held)), file(f, H5Fclose), links(l, H5Pclose) {}

  [[noreturn]] void fail() const {
    const int reason = disk_error;
    throw Error("write-failed",
                "cannot write '" + path.string() +
                    "': " + (reason ? std::strerror(reason) : "the HDF5 library failed"),
                "check the folder, its permissions and free space");
  }
  hid_t checked(hid_t id) const {
    if (id < 0) fail();
    return id;
  }
};

Hdf5Output::Hdf5Output(const std::filesystem::path& path, bool compress) : compress_(compress) {
  std::unique_lock<std::mutex> lock(library_mutex());
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are reported, not printed
  const hid_t links = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(links, 1);
  Hdf5Handle access(disk_access(), H5Pclose);
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  state_ = std::make_unique<State>(path, file, links, std::move(lock));
  state_->checked(file);
}

Hdf5Output::~Hdf5Output() = default;

void Hdf5Output::group(const std::string& path) {
  Hdf5Handle g(
      state_->checked(H5Gcreate2(state_->file, path.c_str(), state_->links, H5P_DEFAULT, H5P_DEFAULT)),
      H5Gclose);
  if (!g.close()) state_->fail();
}

void Hdf5Output::dataset(const std::string& path, Hdf5Type type, const std::vector<std::uint64_t>& size,
                         std::uint64_t rows,
                         const std::function<void(std::uint64_t, std::uint64_t, void*)>& fill) {
  const std::vector<hsize_t> extent(size.begin(), size.end());
  Hdf5Handle space(state_->checked(H5Screate_simple(count_of(extent), extent.data(), nullptr)), H5Sclose);
  Hdf5Handle how(state_->checked(H5Pcreate(H5P_DATASET_CREATE)), H5Pclose);
  H5Pset_obj_track_times(how, false);  // equal content gives equal bytes
  std::uint64_t row = H5Tget_size(hdf5_type(type));
  for (std::size_t a = 1; a < size.size(); ++a) row *= size[a];
  if (compress_ && row >= kSmallestChunk && row <= kLargestChunk) {
    std::vector<hsize_t> chunk = extent;
    chunk[0] = 1;
    if (H5Pset_chunk(how, count_of(chunk), chunk.data()) < 0 || H5Pset_deflate(how, 4) < 0) state_->fail();
  }
  Hdf5Handle data(state_->checked(H5Dcreate2(state_->file, path.c_str(), hdf5_type(type), space,
                                             state_->links, how, H5P_DEFAULT)),
                  H5Dclose);
  std::vector<char> block(std::min(rows, size[0]) * row);
  for (std::uint64_t first = 0; first < size[0]; first += rows) {
    const std::uint64_t count = std::min(rows, size[0] - first);
    fill(first, first + count, block.data());
    std::vector<hsize_t> start(extent.size(), 0), part = extent;
    start[0] = first;
    part[0] = count;
    Hdf5Handle memory(state_->checked(H5Screate_simple(count_of(part), part.data(), nullptr)), H5Sclose);
    if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, part.data(), nullptr) < 0 ||
        H5Dwrite(data, hdf5_type(type), memory, space, H5P_DEFAULT, block.data()) < 0 || disk_error != 0)
      state_->fail();
  }
  if (!data.close()) state_->fail();
}

void Hdf5Output::dataset(const std::string& path, Hdf5Type type, const std::vector<std::uint64_t>& size,
                         const void* data) {
  std::uint64_t bytes = H5Tget_size(hdf5_type(type));
  for (const std::uint64_t n : size) bytes *= n;
  dataset(path, type, size, size[0],
          [&](std::uint64_t, std::uint64_t, void* out) { std::memcpy(out, data, bytes); });
}

void Hdf5Output::texts(const std::string& path, const std::vector<std::string>& texts) {
  Hdf5Handle type(state_->checked(H5Tcopy(H5T_C_S1)), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  const hsize_t count = texts.size();
  Hdf5Handle space(state_->checked(H5Screate_simple(1, &count, nullptr)), H5Sclose);
  Hdf5Handle how(state_->checked(H5Pcreate(H5P_DATASET_CREATE)), H5Pclose);
  H5Pset_obj_track_times(how, false);
  Hdf5Handle data(
      state_->checked(H5Dcreate2(state_->file, path.c_str(), type, space, state_->links, how, H5P_DEFAULT)),
      H5Dclose);
  std::vector<const char*> pointers;
  for (const auto& t : texts) pointers.push_back(t.c_str());
  if (H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) < 0 || !data.close())
    state_->fail();
}

void Hdf5Output::text(const std::string& path, const std::string& text) {
  Hdf5Handle type(state_->checked(H5Tcopy(H5T_C_S1)), H5Tclose);
  H5Tset_size(type, text.size() + 1);
  const hsize_t one = 1;
  Hdf5Handle space(state_->checked(H5Screate_simple(1, &one, nullptr)), H5Sclose);
  Hdf5Handle how(state_->checked(H5Pcreate(H5P_DATASET_CREATE)), H5Pclose);
  H5Pset_obj_track_times(how, false);
  Hdf5Handle data(
      state_->checked(H5Dcreate2(state_->file, path.c_str(), type, space, state_->links, how, H5P_DEFAULT)),
      H5Dclose);
  if (H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()) < 0 || !data.close()) state_->fail();
}

void Hdf5Output::attribute(const std::string& path, const std::string& name, const std::string& text) {
  Hdf5Handle type(state_->checked(H5Tcopy(H5T_C_S1)), H5Tclose);
  H5Tset_size(type, text.size() + 1);
  Hdf5Handle space(state_->checked(H5Screate(H5S_SCALAR)), H5Sclose);
  Hdf5Handle at(state_->checked(H5Acreate_by_name(state_->file, path.c_str(), name.c_str(), type, space,
                                                  H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)),
                H5Aclose);
  if (H5Awrite(at, type, text.c_str()) < 0 || !at.close()) state_->fail();
}

void Hdf5Output::attribute(const std::string& path, const std::string& name, Hdf5Type type,
                           std::uint64_t count, const void* data) {
  const hsize_t size = count;
  Hdf5Handle space(state_->checked(H5Screate_simple(1, &size, nullptr)), H5Sclose);
  Hdf5Handle at(state_->checked(H5Acreate_by_name(state_->file, path.c_str(), name.c_str(), hdf5_type(type),
                                                  space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)),
                H5Aclose);
  if (H5Awrite(at, hdf5_type(type), data) < 0 || !at.close()) state_->fail();
}

void Hdf5Output::finish() {
  const bool closed = state_->links.close() && state_->file.close();
  if (!closed || disk_error != 0) state_->fail();
  state_.reset();
}

}  // namespace terrazzo::exporting
