"""Numbers too small for the normal range of floats, taken for zero while a core computes a drop.

Ahead of a stress wave displacements fall off to 1e-38 mm and below. Such numbers mean nothing, but many processors compute with
them a hundred times slower: one core of an Intel Xeon did 6 million TET10 updates a second with them, 18 without. The mode belongs
to the thread, so it is put back before a kernel ends: what else runs in the thread, numpy say, computes as before.
"""

# mypy: disable-error-code="untyped-decorator"
# Warp reads the annotations of its functions itself: they are calls.

from __future__ import annotations

from mechstyle._warp import wp

wp.set_module_options({"enable_backward": False})


@wp.func_native("""
#if defined(__x86_64__)
    const unsigned int before = __builtin_ia32_stmxcsr();
    __builtin_ia32_ldmxcsr(before | 0x8040u);  // flush to zero, denormals are zero
    return before;
#elif defined(__aarch64__)
    unsigned long before;
    __asm__ volatile("mrs %0, fpcr" : "=r"(before));
    __asm__ volatile("msr fpcr, %0" : : "r"(before | (1ul << 24)));  // flush to zero
    return (unsigned int)before;
#else
    return 0u;
#endif
""")
def flush_subnormals() -> wp.uint32:
    """Take subnormal numbers for zero in this thread; returns the mode before, for `restore_mode`."""


@wp.func_native("""
#if defined(__x86_64__)
    __builtin_ia32_ldmxcsr(mode);
#elif defined(__aarch64__)
    __asm__ volatile("msr fpcr, %0" : : "r"((unsigned long)mode));
#endif
""")
def restore_mode(mode: wp.uint32) -> None:
    """Restore the floating-point mode saved by `flush_subnormals`."""
