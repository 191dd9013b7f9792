#include "runtime/intermediates.h"

#include "runtime/cache/store.h"

namespace terrazzo {

std::shared_ptr<const void> Intermediates::find(const Hash& key) const {
  return store_ ? store_->find_kept(key) : nullptr;
}

void Intermediates::keep(const Hash& key, std::shared_ptr<const void> data, std::uint64_t bytes,
                         double seconds) const {
  if (store_) store_->keep(key, std::move(data), bytes, seconds);
}

}  // namespace terrazzo
