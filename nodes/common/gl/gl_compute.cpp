#include "nodes/common/gl/gl_compute.h"

#include <cstring>

namespace terrazzo {
namespace {

constexpr std::size_t kStaging = 64 << 20;  // bytes

}  // namespace

// Through memory that the device can write: reading into any other, drivers copy 1 GB per second.
void GlCompute::read(GLuint buffer, std::size_t from, std::size_t bytes, void* to) {
  constexpr GLbitfield kFlags = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
  if (!staged_) {
    GenBuffers(1, &staging_);
    BindBuffer(GL_COPY_WRITE_BUFFER, staging_);
    BufferStorage(GL_COPY_WRITE_BUFFER, kStaging, nullptr, kFlags | GL_CLIENT_STORAGE_BIT);
    staged_ = static_cast<const char*>(MapBufferRange(GL_COPY_WRITE_BUFFER, 0, kStaging, kFlags));
    check();
    if (!staged_)
      throw Error("no-gl", "the driver " + context.renderer() + " cannot map a buffer", "set device: cpu")
          .parameter("device");
  }
  for (std::size_t done = 0; done < bytes; done += kStaging) {
    const std::size_t part = std::min(kStaging, bytes - done);
    BindBuffer(GL_COPY_READ_BUFFER, buffer);
    BindBuffer(GL_COPY_WRITE_BUFFER, staging_);
    CopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, from + done, 0, part);
    MemoryBarrier(GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT);
    Finish();
    Work().parallel(part, 4 << 20, [&](std::size_t begin, std::size_t end) {
      std::memcpy(static_cast<char*>(to) + done + begin, staged_ + begin, end - begin);
    });
  }
}

}  // namespace terrazzo
