// Maintenance of the disk cache.
#include <atomic>
#include <chrono>
#include <future>

#include "runtime/cache/cache_folder.h"
#include "runtime/cache/disk_cache.h"
#include "runtime/clients/python/outside.h"
#include "runtime/clients/python/run_object.h"
#include "runtime/work.h"

namespace terrazzo::python {
namespace {

void require_cache(const std::string& folder) { require_cache_folder(folder); }

py::dict stats(const std::string& folder) {
  require_cache(folder);
  CacheStats s;
  {
    const Outside outside;
    s = cache_stats(folder);
  }
  py::dict types, out;
  for (const auto& [type, kind] : s.by_type) types[type.c_str()] = py::make_tuple(kind.count, kind.bytes);
  out["folder"] = folder;
  out["bytes"] = s.bytes();
  out["limit"] = kDefaultCacheLimit;
  out["values"] = s.values.count;
  out["value_bytes"] = s.values.bytes;
  out["records"] = s.records.count;
  out["values_in_records"] = s.in_records;
  out["record_bytes"] = s.records.bytes;
  out["seconds"] = s.seconds;
  out["types"] = types;
  return out;
}

py::dict collect(const std::string& folder, std::uint64_t limit) {
  require_cache(folder);
  Collected c;
  {
    const Outside outside;
    c = collect_cache(folder, limit);
  }
  py::dict out;
  out["values"] = c.values;
  out["records"] = c.records;
  out["leftovers"] = c.leftovers;
  out["bytes"] = c.bytes;
  out["left"] = c.left;
  out["busy"] = c.busy;
  return out;
}

// Recomputes on this thread. Signals are handled when it ends; nodes in Python are recomputed like others.
py::dict verify(const std::string& folder, std::uint64_t sample, std::uint64_t seed) {
  require_cache(folder);
  require_workers();
  Verified v;
  {
    const InCode in_code;
    std::atomic<bool> cancel{false};
    auto future = std::async(std::launch::async, [&] {
      return verify_cache(folder, registry(), value_types(), sample, seed, Work(&cancel, nullptr));
    });
    bool stop = false;
    for (bool end = false; !end;) {
      {
        const Outside outside;
        end = future.wait_for(std::chrono::milliseconds(50)) == std::future_status::ready;
      }
      if (!stop && PyErr_CheckSignals() != 0) stop = cancel = true;
      if (exiting()) cancel = true;
    }
    if (stop) throw py::error_already_set();
    v = future.get();
  }
  py::dict out;
  out["values"] = v.values;
  out["records"] = v.records;
  out["damaged"] = v.damaged;
  out["recomputed"] = v.recomputed;
  out["skipped"] = v.passed_over;
  out["differing"] = v.differing;
  return out;
}

}  // namespace

void bind_cache(py::module_& m) {
  m.def("cache_stats", stats);
  m.def("cache_collect", collect);
  m.def("cache_verify", verify);
  m.def("cache_clear", [](const std::string& folder) {
    require_cache(folder);
    const Outside outside;
    clear_cache(folder);
  });
  m.def("cache_tend", [](const std::string& folder) {
    const Outside outside;
    tend_cache(folder, kDefaultCacheLimit);
  });
  m.attr("cache_limit") = kDefaultCacheLimit;
}

}  // namespace terrazzo::python
