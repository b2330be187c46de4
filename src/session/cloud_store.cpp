#include "scslam/session/cloud_store.h"

#include "scslam/core/pcd.h"
#include "scslam/session/layout.h"

namespace scslam {
namespace {

std::size_t bytesOf(const Cloud& cloud) {
  return sizeof(float) * (3 * cloud.size() + cloud.intensity.size() + cloud.dt.size()) +
         sizeof(std::uint16_t) * cloud.ring.size();
}

}  // namespace

CloudStore::CloudStore(std::filesystem::path folder, std::size_t budget_bytes,
                       std::function<Cloud(const Cloud&)> prepare)
    : folder_(std::move(folder)), prepare_(std::move(prepare)), budget_bytes_(budget_bytes) {}

std::shared_ptr<const Cloud> CloudStore::get(KeyframeId k) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = where_.find(k); found != where_.end()) {
      entries_.splice(entries_.begin(), entries_, found->second);
      return found->second->cloud;
    }
  }
  Cloud read = readPcd(layout::scanFile(folder_, k));
  const auto cloud = std::make_shared<const Cloud>(prepare_ ? prepare_(read) : std::move(read));
  const std::lock_guard lock(mutex_);
  ++reads_;
  if (where_.count(k) != 0) return cloud;  // another thread was faster
  entries_.push_front({k, cloud, bytesOf(*cloud)});
  where_[k] = entries_.begin();
  cached_bytes_ += entries_.front().bytes;
  while (cached_bytes_ > budget_bytes_ && entries_.size() > 1) {
    cached_bytes_ -= entries_.back().bytes;
    where_.erase(entries_.back().k);
    entries_.pop_back();
  }
  return cloud;
}

std::size_t CloudStore::cachedBytes() const {
  const std::lock_guard lock(mutex_);
  return cached_bytes_;
}

std::size_t CloudStore::reads() const {
  const std::lock_guard lock(mutex_);
  return reads_;
}

}  // namespace scslam
