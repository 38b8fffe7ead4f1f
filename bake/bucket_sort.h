// BucketSort: sorts things that have an index few of them share. Private to bake.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace overcast {

/// `items` (fewer than 2^32) sorted by bucket(item), below `buckets`, and within a bucket by `less`, a total order: one pass to count, one
/// to place, then the buckets by themselves. Runs on the calling TBB arena.
template <class T, class Bucket, class Less>
std::vector<T> bucketSorted(const std::vector<T>& items, std::size_t buckets, Bucket bucket, Less less) {
  std::vector<std::uint32_t> end(buckets + 1, 0);
  for (const T& item : items) ++end[bucket(item) + 1];
  for (std::size_t i = 1; i < end.size(); ++i) end[i] += end[i - 1];
  std::vector<std::uint32_t> next(end.begin(), end.end() - 1);
  std::vector<T> sorted(items.size());
  for (const T& item : items) sorted[next[bucket(item)]++] = item;
  constexpr std::size_t kGrain = 4096;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, buckets, kGrain), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) std::sort(sorted.begin() + end[i], sorted.begin() + end[i + 1], less);
  });
  return sorted;
}

}  // namespace overcast
