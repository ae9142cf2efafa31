/*
 * Lets user-mode Linux 6.1 start on processors with large extended registers (AMX: 11 KiB instead of at most 2.7 KiB).
 * Built and preloaded by vcan_uml.sh where the processor has them.
 *
 * User-mode Linux keeps the registers of its guests' programs in 2696 bytes and gives these back by PTRACE_SETREGSET.
 * The kernel takes a whole set only, so the call fails with EFAULT, and the guest panics at its first program. Here the
 * part is laid over the set as it is, which is then whole. What is beyond the part is the tile registers, which no
 * program here uses: a program has to ask the kernel for them (arch_prctl) first.
 */
#define _GNU_SOURCE
#include <elf.h>
#include <errno.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#ifndef NT_X86_XSTATE
#define NT_X86_XSTATE 0x202
#endif

static long set_registers(pid_t pid, const struct iovec *part)
{
    static char whole[1 << 14];
    struct iovec all = { whole, sizeof whole };

    if (syscall(SYS_ptrace, PTRACE_GETREGSET, pid, NT_X86_XSTATE, &all) < 0)
        return -1;
    memcpy(whole, part->iov_base, part->iov_len < all.iov_len ? part->iov_len : all.iov_len);
    return syscall(SYS_ptrace, PTRACE_SETREGSET, pid, NT_X86_XSTATE, &all);
}

long ptrace(enum __ptrace_request request, ...)
{
    va_list rest;

    va_start(rest, request);
    pid_t pid = va_arg(rest, pid_t);
    void *address = va_arg(rest, void *);
    void *data = va_arg(rest, void *);
    va_end(rest);

    switch ((int)request) {
    case PTRACE_SETREGSET:
        if ((unsigned long)address == NT_X86_XSTATE)
            return set_registers(pid, data);
        break;
    case PTRACE_PEEKTEXT:
    case PTRACE_PEEKDATA:
    case PTRACE_PEEKUSER: {
        /* The system call stores what the C library's function gives as its value. */
        long value;

        if (syscall(SYS_ptrace, request, pid, address, &value) < 0)
            return -1;
        errno = 0;
        return value;
    }
    }
    return syscall(SYS_ptrace, request, pid, address, data);
}
