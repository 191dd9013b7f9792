#include "nodes/common/gl/gl_compute.h"

#include <cstring>

namespace terrazzo {

// Makes memory that the device writes and this process reads.
void GlCompute::stage(std::size_t bytes) {
  constexpr GLbitfield kFlags = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
  if (staging_) DeleteBuffers(1, &staging_);
  GenBuffers(1, &staging_);
  BindBuffer(GL_COPY_WRITE_BUFFER, staging_);
  const auto size = static_cast<GLsizeiptr>(bytes);
  BufferStorage(GL_COPY_WRITE_BUFFER, size, nullptr, kFlags | GL_CLIENT_STORAGE_BIT);
  staged_ = static_cast<const char*>(MapBufferRange(GL_COPY_WRITE_BUFFER, 0, size, kFlags));
  staging_bytes_ = bytes;
  check();
  if (!staged_)
    throw Error("no-gl", "the driver " + context.renderer() + " cannot map a buffer", words.otherwise)
        .parameter("device");
}

// Into ordinary memory, drivers copy only 1 GB per second.
void GlCompute::read(GLuint buffer, std::size_t from, std::size_t bytes, void* to) {
  constexpr std::size_t kMost = 64 << 20;
  const std::size_t wanted = std::min(bytes, kMost);
  if (wanted > staging_bytes_) stage(wanted);
  for (std::size_t done = 0; done < bytes; done += staging_bytes_) {
    const std::size_t part = std::min(staging_bytes_, bytes - done);
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
