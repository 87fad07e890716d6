/* Preloaded before the C library: counts what asks for memory, C++'s new and Eigen included. */
#include <stddef.h>

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

static unsigned long count;
unsigned long malloc_count(void) { return __atomic_load_n(&count, __ATOMIC_RELAXED); }
static void one(void) { __atomic_fetch_add(&count, 1, __ATOMIC_RELAXED); }

void* malloc(size_t n) { return one(), __libc_malloc(n); }
void* calloc(size_t n, size_t size) { return one(), __libc_calloc(n, size); }
void* realloc(void* p, size_t n) { return one(), __libc_realloc(p, n); }
void* aligned_alloc(size_t to, size_t n) { return one(), __libc_memalign(to, n); }
int posix_memalign(void** p, size_t to, size_t n) {
  one();
  *p = __libc_memalign(to, n);
  return *p ? 0 : 12;
}
