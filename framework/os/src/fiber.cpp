#include <takt/os/fiber.hpp>

#include <cstdint>
#include <utility>

#include <sys/mman.h>
#include <ucontext.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/asan_interface.h>
#include <sanitizer/common_interface_defs.h>
#endif
#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

#include <takt/core/check.hpp>

namespace takt::os {

struct Fiber::Course {
  ucontext_t context{};
  // A guard page followed by the stack; null for a fiber that uses the thread's own stack.
  std::byte* memory = nullptr;
  std::size_t size = 0;
  std::function<void()> body;
  // The members below are used only with sanitizers.
  const void* bottom = nullptr;
  std::size_t stack_bytes = 0;
  void* fake_stack = nullptr;
  void* tsan = nullptr;
  Course* came_from = nullptr;

  void arrived() {
#if defined(__SANITIZE_ADDRESS__)
    __sanitizer_finish_switch_fiber(fake_stack, &came_from->bottom, &came_from->stack_bytes);
#endif
  }
};

Fiber::Fiber() : course_(std::make_unique<Course>()) {
#if defined(__SANITIZE_THREAD__)
  course_->tsan = __tsan_get_current_fiber();
#endif
}

Fiber::Fiber(std::size_t stack_bytes, std::function<void()> body) : course_(std::make_unique<Course>()) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  Course& course = *course_;
  course.body = std::move(body);
  course.stack_bytes = (stack_bytes + page - 1) / page * page;
  course.size = course.stack_bytes + page;
  void* memory =
      mmap(nullptr, course.size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  TAKT_CHECK(memory != MAP_FAILED);
  TAKT_CHECK(mprotect(memory, page, PROT_NONE) == 0);
  course.memory = static_cast<std::byte*>(memory);
  course.bottom = course.memory + page;
  TAKT_CHECK(getcontext(&course.context) == 0);
  course.context.uc_stack.ss_sp = course.memory + page;
  course.context.uc_stack.ss_size = course.stack_bytes;
  course.context.uc_link = nullptr;
  // makecontext() can pass only ints to the function, so the address of `course` is passed in two parts.
  const auto address = reinterpret_cast<std::uintptr_t>(&course);
  makecontext(&course.context, reinterpret_cast<void (*)()>(&Fiber::enter), 2,
              static_cast<unsigned>(address & 0xffff'ffffU), static_cast<unsigned>(address >> 32));
#if defined(__SANITIZE_THREAD__)
  course.tsan = __tsan_create_fiber(0);
#endif
}

Fiber::~Fiber() {
  if (course_->memory == nullptr) return;
#if defined(__SANITIZE_ADDRESS__)
  __asan_unpoison_memory_region(course_->memory, course_->size);
#endif
#if defined(__SANITIZE_THREAD__)
  __tsan_destroy_fiber(course_->tsan);
#endif
  munmap(course_->memory, course_->size);
}

void Fiber::enter(unsigned low, unsigned high) {
  auto* course =
      reinterpret_cast<Course*>(static_cast<std::uintptr_t>(low) | static_cast<std::uintptr_t>(high) << 32);
  course->arrived();
  course->body();
  TAKT_CHECK(false && "the body of a fiber does not return");
}

void Fiber::hand_over_to(Fiber& other) {
  Course& from = *course_;
  Course& to = *other.course_;
  to.came_from = &from;
#if defined(__SANITIZE_ADDRESS__)
  __sanitizer_start_switch_fiber(&from.fake_stack, to.bottom, to.stack_bytes);
#endif
#if defined(__SANITIZE_THREAD__)
  __tsan_switch_to_fiber(to.tsan, 0);
#endif
  TAKT_CHECK(swapcontext(&from.context, &to.context) == 0);
  from.arrived();
}

}  // namespace takt::os
