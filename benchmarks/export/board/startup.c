/* Start of a program on QEMU's MPS2 board with a Cortex-M7: FPU, memory, semihosting. */
#include <string.h>

extern char __data_load[], __data_start[], __data_end[], __bss_start[], __bss_end[], _stack[];
extern int main(void);
extern void initialise_monitor_handles(void);
extern void exit(int);

void Reset_Handler(void)
{
    *(volatile unsigned *)0xE000ED88 |= 0xFu << 20; /* CPACR: full access to the FPU */
    __asm volatile("dsb\n isb");
    memcpy(__data_start, __data_load, (size_t)(__data_end - __data_start));
    memset(__bss_start, 0, (size_t)(__bss_end - __bss_start));
    initialise_monitor_handles();
    exit(main());
}

void Hang(void)
{
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) void *vectors[] = {
    _stack, Reset_Handler, Hang, Hang, Hang, Hang, Hang};

void _init(void) {}
void _fini(void) {}
