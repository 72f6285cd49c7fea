autocmd BufRead,BufNewFile *.arael setfiletype arael
