#include "core/parallel.hpp"

#if KT_WITH_TBB
#include <tbb/parallel_for.h>
#endif

namespace kt {

void parallel_for(int count, const std::function<void(int)>& work) {
#if KT_WITH_TBB
  tbb::parallel_for(0, count, work);
#else
  for (int i = 0; i < count; ++i) work(i);
#endif
}

}  // namespace kt
