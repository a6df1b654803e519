#include "core/base/parallel.hpp"

#if KT_WITH_TBB
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace kt {

void parallel_for(int count, const std::function<void(int)>& work) {
  if (count == 1) return work(0);
#if KT_WITH_TBB
  tbb::parallel_for(0, count, work);
#else
  for (int i = 0; i < count; ++i) work(i);
#endif
}

void with_threads(int threads, const std::function<void()>& work) {
#if KT_WITH_TBB
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena(threads).execute(work);
#else
  (void)threads;
  work();
#endif
}

}  // namespace kt
