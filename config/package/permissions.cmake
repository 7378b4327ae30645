# Before the package is packed: whoever's umask it is, everybody may read it and nobody but root may write.
execute_process(COMMAND chmod -R u=rwX,go=rX ${CPACK_TEMPORARY_DIRECTORY} COMMAND_ERROR_IS_FATAL ANY)
